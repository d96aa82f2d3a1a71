"""Square runs out of recordings."""

from dataclasses import replace

import numpy as np
import pytest

from omnimate.calib.apply import corrected_truck
from omnimate.calib.errors import CalibrationError, FixError
from omnimate.calib.fixes import mean_pose
from omnimate.calib.recordings import has_fixes
from omnimate.calib.umbmark.exact import square_returns
from omnimate.calib.umbmark.runs import square_runs
from omnimate.vehicle.parameters import Truck
from omnimate.vehicle.recording import Poses, Recording, Run

BELIEVED = Truck(0.34, 0.15, 0.15)
ACTUAL = corrected_truck(BELIEVED, 0.98874, 1.00084)


@pytest.fixture
def recording(drive_squares) -> Recording:
    return drive_squares(BELIEVED, ACTUAL)


def test_runs_have_the_errors_of_the_chain(drive_squares) -> None:
    """Wherever the robot starts, each lap's return error is that of the exact chain, in the start's frame."""
    recording = drive_squares(BELIEVED, ACTUAL, ("cw", "ccw", "cw"))
    chain = dict(zip(("cw", "ccw"), square_returns(BELIEVED, ACTUAL, 4.0), strict=True))
    runs = square_runs(recording)
    assert [run.direction for run in runs] == ["cw", "ccw", "cw"]
    for run in runs:
        run.check(BELIEVED, 4.0)
        assert run.return_error(BELIEVED) == pytest.approx(chain[run.direction], abs=1e-5)
        assert run.return_error(ACTUAL) == pytest.approx(np.zeros(3), abs=1e-5)


def test_fixes_of_one_rest_are_averaged_and_moving_ones_left_out(recording) -> None:
    """A rest's three fixes count by their inverse variance; one on the way counts for nothing."""
    poses = recording.poses
    moving = 0.5 * (poses.time[0] + poses.time[1])
    time = np.array([poses.time[0], poses.time[0] + 0.1, poses.time[0] + 0.2, moving, *poses.time[1:]])
    pose = np.vstack(
        [poses.pose[[0, 0, 0]] + [[0.01, 0, 0], [-0.01, 0, 0], [5, 5, 0]], [9, 9, 9], poses.pose[1:]]
    )
    sigma = np.vstack([[[0.002] * 3] * 2, [[1e6] * 3], [[0.002] * 3] * 3])
    busy = replace(recording, poses=Poses(time, np.full(len(time), "a"), pose, sigma))
    for run, plain in zip(square_runs(busy), square_runs(recording), strict=True):
        assert run.absolute == pytest.approx(plain.absolute, abs=1e-5)


def test_only_the_truck_s_own_fixes_count(recording) -> None:
    """Poses of the other body are not there for this one."""
    assert has_fixes(recording, "a")
    assert not has_fixes(recording, "b")
    poses = recording.poses
    others = replace(poses, body=np.full(len(poses.time), "b"))
    with pytest.raises(CalibrationError, match="no pose of truck a"):
        square_runs(replace(recording, poses=others))


def test_an_unknown_heading_after_the_lap_is_accepted(drive_squares) -> None:
    """A tape measures x and y only: the run's heading error is nan, its position error stands."""
    recording = drive_squares(BELIEVED, ACTUAL, ("cw",))
    poses = recording.poses
    pose = poses.pose.copy()
    pose[1, 2] = np.nan
    run = square_runs(replace(recording, poses=replace(poses, pose=pose)))[0]
    error = run.return_error(BELIEVED)
    assert error[:2] == pytest.approx(square_returns(BELIEVED, ACTUAL, 4.0)[0, :2], abs=1e-5)
    assert np.isnan(error[2])


@pytest.mark.parametrize(("kept", "words"), [([1, 2], "before the lap"), ([0, 1], "after the lap")])
def test_a_missing_fix_is_named(recording, kept: list[int], words: str) -> None:
    """A lap without a fix before or after it is an error with the lap's number."""
    with pytest.raises(FixError, match=words) as caught:
        square_runs(replace(recording, poses=recording.poses.select(kept)))
    assert "lap" in caught.value.source


def test_a_start_without_heading_is_refused(recording) -> None:
    """The frame of the start needs its theta."""
    poses = recording.poses
    with pytest.raises(FixError, match="theta"):
        square_runs(replace(recording, poses=replace(poses, pose=poses.pose * [1, 1, np.nan])))


def test_recordings_without_laps_or_poses_are_refused(recording) -> None:
    """Each says what is missing."""
    with pytest.raises(CalibrationError, match=r"run\.toml"):
        square_runs(replace(recording, run=None))
    with pytest.raises(CalibrationError, match=r"poses\.csv"):
        square_runs(replace(recording, poses=None))


def test_free_laps_are_left_out(recording) -> None:
    """A lap of direction none is no square."""
    laps = (replace(recording.run.laps[0], direction="none"), recording.run.laps[1])
    free = replace(recording, run=Run("umbmark", 4.0, laps))
    assert [run.direction for run in square_runs(free)] == ["ccw"]


def test_absent_samples_do_not_move_the_robot(recording) -> None:
    """A gap while the robot stands changes nothing."""
    present = recording.present.copy()
    present[3:8, 0] = False
    for run, plain in zip(
        square_runs(replace(recording, present=present)), square_runs(recording), strict=True
    ):
        assert run.return_error(BELIEVED) == pytest.approx(plain.return_error(BELIEVED), abs=1e-9)


def test_mean_of_poses_across_the_cut() -> None:
    """Headings at +-180 degrees average to 180, not to 0; without sigma all weigh the same."""
    poses = np.array([[0.0, 0.0, np.pi - 0.01], [2.0, 0.0, -np.pi + 0.03]])
    mean = mean_pose(poses, np.full((2, 3), np.nan))
    assert mean[0] == pytest.approx(1.0)
    assert np.cos(mean[2]) == pytest.approx(np.cos(np.pi + 0.01))
    weighted = mean_pose(poses, np.array([[1.0, 1.0, 1.0], [2.0, 1.0, 1.0]]))
    assert weighted[0] == pytest.approx(0.4)
