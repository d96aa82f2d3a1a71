"""A checked drive of two trucks for the calibration of their linkage: wheels, readings, loop closures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.calib.errors import CalibrationError
from omnimate.calib.estimation.residuals import rotate_covariance
from omnimate.calib.recordings import check_frozen
from omnimate.vehicle.parameters import JOINTS, WHEELS
from omnimate.vehicle.se2 import between, lever_matrix

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from omnimate.vehicle.parameters import Channel
    from omnimate.vehicle.recording import Poses, Recording
    from omnimate.vehicle.se2 import Array

WINDOW = 0.5  # [s] of driving between two used readings (assumption: longer than the joints' noise)
_CLOSURE_TIME = 0.05  # [s] largest time difference of both trucks' poses in a loop closure (assumption)


@dataclass(frozen=True, slots=True)
class LinkageDrive:
    """Readings of the linkage, the loop closures among them, and the wheels in between."""

    wheels: Array  # continuous angles of a.left, a.right, b.left, b.right [rad], `(G, 4)`
    ends: NDArray[np.int64]  # index into `wheels` at each reading, `(M,)`
    time: Array  # time of each reading [s], `(M,)`
    linkage: Array  # readings of joint_a, joint_b [rad] and length [m], `(M, 3)`; not used in loop closures
    closed: NDArray[np.bool_]  # whether a reading is a loop closure, `(M,)`
    relative: Array  # pose of b seen from a, measured from outside, in loop closures, `(M, 3)`
    covariance: Array  # covariance of `relative` in the frame of a, `(M, 3, 3)`
    resolution: Array  # size of a count of joint_a, joint_b [rad] and link [m], `(3,)`
    source: str  # file or folder that the drive comes from, for messages


def linkage_drive(recording: Recording) -> LinkageDrive:
    """Return a recording of a robot with a linkage as a drive with one reading for each window of driving.

    Raises:
        CalibrationError: The robot has a single truck, a counter was lost, or a channel is frozen.
    """
    if recording.vehicle.linkage is None:
        raise CalibrationError(recording.source, "a robot with a single truck has no linkage to calibrate")
    _check(recording)
    usable = recording.present.all(axis=1)
    wheels = np.stack([recording.wheel_angle(wheel) for wheel in WHEELS], axis=-1)[usable]
    readings = [recording.joint_angle(joint) for joint in JOINTS]
    linkage = np.stack([*readings, recording.link_length()], axis=-1)[usable]
    ends, closed, pairs = _events(recording, recording.time[usable], wheels)
    relative, covariance = np.zeros((len(ends), 3)), np.zeros((len(ends), 3, 3))
    if pairs is not None:
        a, b = pairs
        relative[closed] = between(a.pose, b.pose)
        covariance[closed] = closure_covariance(a.pose, b.pose, a.sigma, b.sigma)
    channels: tuple[Channel, ...] = (*JOINTS, "link")
    resolution = np.array([abs(recording.vehicle.encoder(channel).scale) for channel in channels])
    return LinkageDrive(
        wheels,
        ends,
        recording.time[usable][ends],
        linkage[ends],
        closed,
        relative,
        covariance,
        resolution,
        recording.source,
    )


def _check(recording: Recording) -> None:
    """Raise an error if a counter was lost, or a channel is frozen while the robot moves."""
    lost = [gap.channel for gap in recording.gaps if gap.reason in {"reboot", "jump"}]
    if lost:
        raise CalibrationError(
            recording.source,
            f"the counter of {lost[0]} was lost on the way (reboot or jump); use a recording without it",
        )
    check_frozen(recording)


def _events(
    recording: Recording, time: Array, wheels: Array
) -> tuple[NDArray[np.int64], NDArray[np.bool_], tuple[Poses, Poses] | None]:
    """Return the samples `(M,)` of readings and loop closures, which of them are closures, and the poses."""
    moving = np.concatenate(([True], np.any(np.diff(wheels, axis=0) != 0.0, axis=1)))
    driven = np.cumsum(moving * np.diff(time, prepend=time[0]))
    marks = np.arange(0.0, float(driven[-1]) + 1e-9, WINDOW)
    read = np.unique(np.searchsorted(driven, marks))
    if len(read) < 3:
        raise CalibrationError(
            recording.source,
            f"{driven[-1]:.1f} s of driving; the linkage needs more than {2.0 * WINDOW:g} s, with turns",
        )
    pairs = _pairs(recording)
    if pairs is None:
        return read, np.zeros(len(read), np.bool_), None
    at = np.clip(np.searchsorted(time, pairs[0].time), 0, len(time) - 1)
    order = np.argsort(np.concatenate([read, at]), kind="stable")
    closed = np.concatenate([np.zeros(len(read), np.bool_), np.ones(len(at), np.bool_)])
    return np.concatenate([read, at])[order], closed[order], pairs


def _pairs(recording: Recording) -> tuple[Poses, Poses] | None:
    """Return the complete poses of both trucks that were measured at the same time; None without any."""
    if recording.poses is None:
        return None
    a, b = (_complete_poses(recording.poses.of(truck)) for truck in recording.vehicle.trucks)
    if len(a.time) == 0 or len(b.time) == 0:
        return None
    near = np.abs(b.time[:, np.newaxis] - a.time).argmin(axis=0)
    first, last = float(recording.time[0]), float(recording.time[-1])
    good = (np.abs(b.time[near] - a.time) < _CLOSURE_TIME) & (a.time >= first) & (a.time <= last)
    if not good.any():
        return None
    return a.select(good), b.select(near[good])


def _complete_poses(poses: Poses) -> Poses:
    known = np.isfinite(poses.pose).all(axis=1) & np.isfinite(poses.sigma).all(axis=1)
    return poses.select(known)


def closure_covariance(pose_a: Array, pose_b: Array, sigma_a: Array, sigma_b: Array) -> Array:
    """Return the covariance `(M, 3, 3)` of b seen from a, both measured from outside `(M, 3)`, frame of a."""
    lever = lever_matrix(between(pose_a, pose_b)[:, :2])
    spread_a = rotate_covariance(_diagonal(sigma_a), pose_a[:, 2])
    return lever @ spread_a @ lever.transpose(0, 2, 1) + rotate_covariance(_diagonal(sigma_b), pose_a[:, 2])


def _diagonal(sigma: Array) -> Array:
    return np.asarray(sigma[:, :, np.newaxis] ** 2 * np.eye(3), np.float64)
