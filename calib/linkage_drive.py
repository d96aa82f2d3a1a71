"""A drive of two trucks for the calibration of their linkage: wheels, readings and loop closures, checked."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from calib.errors import CalibrationError
from calib.residuals import turned
from vehicle.odometry import truck_travel
from vehicle.parameters import JOINTS, WHEELS
from vehicle.se2 import between

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vehicle.parameters import Channel
    from vehicle.recording import Poses, Recording
    from vehicle.se2 import Array

_TURNED = math.radians(20.0)  # heading of a truck from which a joint that never moves is not believed
_ROLLED = 2.0  # [m] way from which a link that never moves is not believed
_TOGETHER = 0.05  # [s] within which poses of both trucks are one loop closure


@dataclass(frozen=True, slots=True)
class LinkageDrive:
    """Readings of the linkage, the loop closures among them, and the wheels in between.

    Attributes:
        wheels: (G, 4) angles of a.left, a.right, b.left, b.right [rad], continuous.
        ends: (M,) index into `wheels` at each reading.
        time: (M,) of each reading [s].
        linkage: (M, 3) joint_a, joint_b [rad], length [m]; not used in loop closures.
        closed: (M,) whether this is a loop closure instead.
        relative: (M, 3) pose of b seen from a, measured from outside, in loop closures.
        covariance: (M, 3, 3) of it, frame of a.
        resolution: (3,) one count of joint_a, joint_b [rad], link [m].
        source: for messages.
    """

    wheels: Array
    ends: NDArray[np.int64]
    time: Array
    linkage: Array
    closed: NDArray[np.bool_]
    relative: Array
    covariance: Array
    resolution: Array
    source: str


def linkage_drive(recording: Recording, window: float, *, closures: bool) -> LinkageDrive:
    """Return a recording as a drive with one reading per window of driving [s].

    Args:
        recording: of a robot with a linkage.
        window: between readings [s].
        closures: whether absolute poses of both trucks at the same time are used.

    Raises:
        CalibrationError: one truck only, lost counters, or a channel that is frozen.
    """
    if recording.vehicle.linkage is None:
        raise CalibrationError(recording.source, "a robot with a single truck has no linkage to calibrate")
    _check(recording)
    usable = recording.present.all(axis=1)
    wheels = np.stack([recording.wheel_angle(wheel) for wheel in WHEELS], axis=-1)[usable]
    readings = [recording.joint_angle(joint) for joint in JOINTS]
    linkage = np.stack([*readings, recording.link_length()], axis=-1)[usable]
    ends, closed, pairs = _events(recording, recording.time[usable], wheels, window, closures=closures)
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
    """Refuse a drive in which a counter was lost, or a channel stands still while the robot moves."""
    lost = [gap.channel for gap in recording.gaps if gap.reason in {"reboot", "jump"}]
    if lost:
        raise CalibrationError(
            recording.source,
            f"the counter of {lost[0]} was lost on the way (reboot or jump); use a recording without it",
        )
    moved = {
        channel: int(np.ptp(recording.channel_counts(channel))) for channel in recording.vehicle.channels
    }
    vehicle, turned_most, rolled_least = recording.vehicle, 0.0, math.inf
    for truck in vehicle.trucks:
        left, right, _ = truck_travel(recording, truck)
        turn = (right - left) / vehicle.trucks[truck].wheelbase
        turned_most = max(turned_most, float(np.ptp(turn)))
        rolled_least = min(rolled_least, float(np.abs(np.diff(0.5 * (left + right))).sum()))
    frozen = [wheel for wheel in WHEELS if moved[wheel] == 0]
    frozen += [joint for joint in JOINTS if moved[joint] == 0 and turned_most > _TURNED]
    frozen += ["link"] if moved["link"] == 0 and rolled_least > _ROLLED and turned_most > _TURNED else []
    if frozen:
        raise CalibrationError(
            recording.source,
            f"channel {frozen[0]} never changes while the robot drives and turns: it is frozen; check its "
            "encoder, and node, cob_id and start_bit in vehicle.toml",
        )


def _events(
    recording: Recording, time: Array, wheels: Array, window: float, *, closures: bool
) -> tuple[NDArray[np.int64], NDArray[np.bool_], tuple[Poses, Poses] | None]:
    """Return the samples `(M,)` of readings and loop closures, which are closures, and their poses."""
    moving = np.concatenate(([True], np.any(np.diff(wheels, axis=0) != 0.0, axis=1)))
    driven = np.cumsum(moving * np.diff(time, prepend=time[0]))
    marks = np.arange(0.0, float(driven[-1]) + 1e-9, window)
    read = np.unique(np.searchsorted(driven, marks))
    if len(read) < 3:
        raise CalibrationError(
            recording.source,
            f"{driven[-1]:.1f} s of driving; the linkage needs more than {2.0 * window:g} s, with turns",
        )
    pairs = _pairs(recording) if closures else None
    if pairs is None:
        return read, np.zeros(len(read), np.bool_), None
    at = np.clip(np.searchsorted(time, pairs[0].time), 0, len(time) - 1)
    order = np.argsort(np.concatenate([read, at]), kind="stable")
    closed = np.concatenate([np.zeros(len(read), np.bool_), np.ones(len(at), np.bool_)])
    return np.concatenate([read, at])[order], closed[order], pairs


def _pairs(recording: Recording) -> tuple[Poses, Poses] | None:
    """Return the whole poses of both trucks that were measured at the same time; None without any."""
    if recording.poses is None:
        return None
    a, b = (_whole(recording.poses.of(truck)) for truck in recording.vehicle.trucks)
    if len(a.time) == 0 or len(b.time) == 0:
        return None
    near = np.abs(b.time[:, np.newaxis] - a.time).argmin(axis=0)
    first, last = float(recording.time[0]), float(recording.time[-1])
    good = (np.abs(b.time[near] - a.time) < _TOGETHER) & (a.time >= first) & (a.time <= last)
    if not good.any():
        return None
    return _chosen(a, np.flatnonzero(good)), _chosen(b, near[good])


def _whole(poses: Poses) -> Poses:
    known = np.isfinite(poses.pose).all(axis=1) & np.isfinite(poses.sigma).all(axis=1)
    return _chosen(poses, np.flatnonzero(known))


def _chosen(poses: Poses, rows: NDArray[np.int64]) -> Poses:
    return type(poses)(poses.time[rows], poses.body[rows], poses.pose[rows], poses.sigma[rows])


def closure_covariance(pose_a: Array, pose_b: Array, sigma_a: Array, sigma_b: Array) -> Array:
    """Return the covariance `(M, 3, 3)` of b seen from a, both measured from outside `(M, 3)`, frame of a."""
    far = between(pose_a, pose_b)
    lever = np.zeros((len(far), 3, 3))
    lever[:] = np.eye(3)
    lever[:, 0, 2], lever[:, 1, 2] = -far[:, 1], far[:, 0]
    spread_a = turned(_diagonal(sigma_a), pose_a[:, 2])
    return lever @ spread_a @ lever.transpose(0, 2, 1) + turned(_diagonal(sigma_b), pose_a[:, 2])


def _diagonal(sigma: Array) -> Array:
    return np.asarray(sigma[:, :, np.newaxis] ** 2 * np.eye(3), np.float64)
