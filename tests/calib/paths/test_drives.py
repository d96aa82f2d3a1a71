"""Drives out of recordings: what is used, and what is refused with a reason."""

from dataclasses import replace

import numpy as np
import pytest

from omnimate.calib.errors import CalibrationError, FixError
from omnimate.calib.paths.drives import drives_of, thin_fixes
from omnimate.vehicle.parameters import Truck
from omnimate.vehicle.recording import Gap
from tests.recordings import frozen

TRUCK = Truck(0.34, 0.15, 0.15)


@pytest.fixture
def recording(drive_squares):
    return drive_squares(TRUCK, Truck(0.336, 0.15, 0.1502), ("cw", "ccw"))


def with_poses(recording, keep=slice(None), **changes):
    return replace(recording, poses=replace(recording.poses, **changes).select(keep))


def test_a_drive_holds_the_wheels_and_all_poses(recording):
    (drive,) = drives_of([recording])
    assert len(drive.fix_time) == 3
    travelled = drive.readings[-1] - drive.readings[0]
    left, right = recording.wheel_angle("a.left"), recording.wheel_angle("a.right")
    np.testing.assert_allclose(travelled, [left[-1] - left[0], right[-1] - right[0]])


def test_readings_at_rest_are_left_out(recording):
    (drive,) = drives_of([recording])
    assert len(drive.time) < len(recording)


def test_a_reboot_cuts_the_drive(recording):
    end = float(recording.poses.time[1]) - 0.05
    more = with_poses(recording, keep=[0, 1, 1, 2])
    time = more.poses.time - np.array([0.0, 1.0, 0.0, 0.0])
    cut = replace(
        more,
        poses=replace(more.poses, time=time),
        gaps=(Gap("a.left", end - 0.1, end, "reboot"),),
    )
    assert [len(drive.fix_time) for drive in drives_of([cut])] == [2, 2]


def with_clock_jump(recording):
    is_late = np.arange(len(recording)) > len(recording) // 4
    return replace(recording, time=np.where(is_late, recording.time + 1e4, recording.time))


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda one: replace(one, poses=None), "no pose of truck a"),
        (lambda one: with_poses(one, time=one.poses.time + 1e6), "expected one clock"),
        (with_clock_jump, "2 of 3 poses .* no samples, .* s: its clock jumps"),
        (lambda one: with_poses(one, keep=slice(1)), "two are needed"),
        (lambda one: with_poses(one, pose=np.full((3, 3), np.nan)), "0 known pose"),
        (lambda one: with_poses(one, keep=[2, 1, 0]), "back in time"),
    ],
)
def test_poses_that_cannot_serve_are_refused_with_what_to_do(recording, spoil, words):
    with pytest.raises(FixError, match=words):
        drives_of([spoil(recording)])


def test_a_wheel_that_never_moves_is_named(recording):
    with pytest.raises(CalibrationError, match=r"a\.right is frozen.*vehicle\.toml"):
        drives_of([frozen(recording, "a.right")])


def test_a_robot_that_stands_is_refused(recording):
    with pytest.raises(CalibrationError, match="neither wheel"):
        drives_of([replace(recording, counts=np.zeros_like(recording.counts))])


def test_thinning_keeps_the_ends_and_the_spacing(recording):
    (drive,) = drives_of([recording])
    time = np.arange(0.0, 10.05, 0.1)
    dense = replace(drive, fix_time=time, pose=np.zeros((len(time), 3)), sigma=np.zeros((len(time), 3)))
    kept = thin_fixes(dense, 2.0).fix_time
    assert kept[0] == time[0]
    assert kept[-1] == time[-1]
    assert np.diff(kept).min() > 1.99
    np.testing.assert_array_equal(thin_fixes(dense, 0.0).fix_time, time)
