"""`run.toml`: what is written is read, and what is wrong is named."""

import pytest

from omnimate.files.recordings.run_toml import read_run, write_run
from omnimate.vehicle.errors import RecordingError
from omnimate.vehicle.recording import Lap, Run


@pytest.mark.parametrize("floor", ["'../x'", "2"])
def test_a_wrong_floor_is_named(tmp_path, floor):
    """Other wrong values stand in `tests/data/logs/broken_runs.toml`."""
    (tmp_path / "run.toml").write_text(f'protocol = "free"\nfloor = {floor}')
    with pytest.raises(RecordingError, match=rf"floor {floor}; expected a name"):
        read_run(tmp_path / "run.toml")


def test_a_number_beyond_all_floats_is_not_finite(tmp_path):
    (tmp_path / "run.toml").write_text(f'protocol = "free"\nside = 1{"0" * 400}')
    with pytest.raises(RecordingError, match=r"side 10+; expected a finite number"):
        read_run(tmp_path / "run.toml")


@pytest.mark.parametrize(
    "run", [Run("free", None, (), "hall-2"), Run("umbmark", 4.0, (Lap("ccw", 1.5, 2.25),))]
)
def test_a_run_is_written_and_read(tmp_path, run):
    write_run(run, tmp_path / "run.toml")
    assert read_run(tmp_path / "run.toml") == run
