"""Files are written whole or not at all."""

import pytest

from omnimate.vehicle import atomic


def test_a_failure_leaves_the_old_content_and_no_litter(tmp_path, monkeypatch):
    path = tmp_path / "vehicle.toml"
    atomic.write_text(path, "old")

    def fail(_descriptor):
        raise OSError("disk full")

    monkeypatch.setattr(atomic.os, "fsync", fail)
    with pytest.raises(OSError, match="disk full"):
        atomic.write_text(path, "new")
    assert path.read_text() == "old"
    assert [entry.name for entry in tmp_path.iterdir()] == ["vehicle.toml"]
