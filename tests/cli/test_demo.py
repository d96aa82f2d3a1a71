"""The demo: a whole UMBmark through the bus, with and without device faults."""

import re

import numpy as np
import pytest

from omnimate.files.recordings.folder import read_recording
from omnimate.vehicle.file import load_vehicle

SMALL = ("--side", "0.5", "--runs", "1")

RETURNS = {}  # of the run without faults, which several tests compare with


def returns(text):
    """Return the return errors x, y [m] and heading [rad] that the demo printed, before calibration."""
    found = re.findall(r"return error of a: x +(\S+) mm +y +(\S+) mm +heading +(\S+) degrees", text)
    return np.array(found[:2], float) * [1e-3, 1e-3, np.pi / 180]


def test_the_demo_writes_both_recordings_the_calibrated_robot_and_the_figures(accepted, tmp_path):
    """It replaces a recording of its own, and leaves other files in its folder alone."""
    for path in (tmp_path / "before/notes.txt", tmp_path / "before/can.log"):
        path.parent.mkdir(exist_ok=True)
        path.write_text("mine")
    result = accepted("demo", "--out", tmp_path, *SMALL)
    for name in ("before", "after"):
        loaded = read_recording(tmp_path / name)
        assert loaded.log.blocks.is_whole
        assert not loaded.recording.gaps
        assert [lap.direction for lap in loaded.recording.run.laps] == ["cw", "ccw"]
        assert set(loaded.recording.poses.body) == {"a", "b"}
    nominal, calibrated = (
        load_vehicle(tmp_path / "before/vehicle.toml"),
        load_vehicle(tmp_path / "vehicle.toml"),
    )
    assert calibrated.trucks != nominal.trucks
    assert load_vehicle(tmp_path / "after/vehicle.toml").trucks == calibrated.trucks
    for figure in ("umbmark.png", "path.png"):
        assert (tmp_path / figure).read_bytes().startswith(b"\x89PNG")
    assert "each answered by every node in time" in result.out
    assert (tmp_path / "before/notes.txt").read_text() == "mine"


@pytest.mark.slow
def test_the_demo_repeats_exactly(omnimate, tmp_path):
    first, second = (omnimate("demo", "--out", tmp_path, *SMALL, "--seed", 3) for _ in range(2))
    assert first.code == second.code == 0
    assert np.array_equal(returns(first.out), returns(second.out))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("faults", "named"),
    [
        (["reboot:node=2,at=6"], ["restarted (boot-up)", "configured again", "a.right (reboot)"]),
        (["silence:node=2,at=6,duration=1"], ["no valid answer to SYNC", "a.right (missing)"]),
        (["babbling:node=3,at=6,duration=1"], ["babbles"]),
        (
            ["reboot:node=2,at=6", "silence:node=1,at=9,duration=0.5", "babbling:node=5,at=12,duration=1"],
            ["restarted (boot-up)", "a.left (missing)", "babbles"],
        ),
    ],
)
def test_a_node_that_fails_mid_square_costs_what_the_lost_samples_explain(
    omnimate, accepted, tmp_path, faults, named
):
    """The run finishes, the report says what happened, and the return errors stay where they were.

    The robot drives at 0.4 m/s and stops 0.1 s after it went blind; the other wheel of the truck bridges
    what a restarted counter lost. Another path meets another roughness of the floor, so the bound is the
    scatter of such a square (25 mm at 4 m, less here) and some slack, far below the 0.1 m lost.
    """
    if "quiet" not in RETURNS:
        RETURNS["quiet"] = returns(omnimate("demo", "--out", tmp_path / "quiet", *SMALL).out)
    options = [word for fault in faults for word in ("--fault", fault)]
    result = accepted("demo", "--out", tmp_path / "faulty", *SMALL, *options)
    for words in named:
        assert words in result.out
    difference = np.abs(returns(result.out) - RETURNS["quiet"])
    assert difference[:, :2].max() < 0.03
    assert difference[:, 2].max() < np.radians(2.0)
