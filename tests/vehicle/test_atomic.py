"""Files are written whole or not at all; what is no file is left as it is."""

import os
import threading
from pathlib import Path

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


def test_a_link_keeps_pointing_to_its_file(tmp_path):
    file, link = tmp_path / "file.csv", tmp_path / "link.csv"
    file.write_text("old")
    link.symlink_to(file)
    atomic.write_text(link, "new")
    assert link.is_symlink()
    assert file.read_text() == "new"


def test_a_file_keeps_its_permissions_and_a_new_one_has_those_of_the_umask(tmp_path):
    old, new = tmp_path / "old.csv", tmp_path / "new.csv"
    old.write_text("old")
    old.chmod(0o600)
    before = os.umask(0o027)
    try:
        atomic.write_text(old, "new")
        atomic.write_text(new, "new")
    finally:
        os.umask(before)
    assert old.stat().st_mode & 0o777 == 0o600
    assert new.stat().st_mode & 0o777 == 0o640


@pytest.mark.skipif(not Path("/dev/fd").exists(), reason="needs /dev/fd")
def test_a_pipe_of_the_shell_is_written_by_its_descriptor():
    """A shell's `>(command)` is /dev/fd/N, a link to what is no path."""
    read, write = os.pipe()
    atomic.write_text(Path(f"/dev/fd/{write}"), "rows")
    os.close(write)
    with os.fdopen(read) as pipe:
        assert pipe.read() == "rows"


def test_a_pipe_is_written_and_stays_a_pipe(tmp_path):
    pipe, read = tmp_path / "pipe", []
    os.mkfifo(pipe)
    reader = threading.Thread(target=lambda: read.append(pipe.read_text()))
    reader.start()
    atomic.write_text(pipe, "rows")
    reader.join()
    assert read == ["rows"]
    assert pipe.is_fifo()


def test_an_error_names_the_file_that_was_asked_for(tmp_path):
    path = tmp_path / "none" / "answer.json"
    with pytest.raises(FileNotFoundError) as caught:
        atomic.write_text(path, "{}")
    assert caught.value.filename == str(path)
