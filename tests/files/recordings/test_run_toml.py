"""`run.toml`: what is written is read, and what is wrong is named."""

import pytest

from omnimate.files.recordings.run_toml import read_run, write_run
from omnimate.vehicle.errors import RecordingError
from omnimate.vehicle.recording import Lap, Run


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("protocol =", "not TOML"),
        ("side = 4.0", "protocol"),
        ('protocol = "umbmark"\nside = "4 m"', "side"),
        ('protocol = "umbmark"\nside = -4', "above 0"),
        ('protocol = "umbmark"\nlap = 3', "[[lap]]"),
        ('protocol = "free"\nfloor = "../x"', "floor '../x'; expected a name"),
        ('protocol = "free"\nfloor = 2', "floor 2; expected a name"),
        ('protocol = "umbmark"\n[[lap]]\ndirection = "left"\nstart = 0\nend = 1', "direction 'left'"),
        ('protocol = "umbmark"\n[[lap]]\ndirection = "cw"\nstart = 2\nend = 1', "not after its start"),
        ('protocol = "umbmark"\n[[lap]]\ndirection = "cw"\nstart = nan\nend = 1', "finite"),
        ('protocol = "umbmark"\n[[lap]]\ndirection = "cw"\nstart = 2', "lap 1: end is missing"),
    ],
)
def test_a_wrong_run_says_what_was_expected(tmp_path, text, problem):
    (tmp_path / "run.toml").write_text(text)
    with pytest.raises(RecordingError) as caught:
        read_run(tmp_path / "run.toml")
    assert problem in str(caught.value)


@pytest.mark.parametrize(
    "run", [Run("free", None, (), "hall-2"), Run("umbmark", 4.0, (Lap("ccw", 1.5, 2.25),))]
)
def test_a_run_is_written_and_read(tmp_path, run):
    write_run(run, tmp_path / "run.toml")
    assert read_run(tmp_path / "run.toml") == run
