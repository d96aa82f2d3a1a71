"""A recording as the signals on which effects act, and the trajectory about which the model is linear."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from omnimate.effects.block import Block
from omnimate.mismatch.recording.causal_path import FORGETTING, follow_linkage, follow_poses
from omnimate.mismatch.recording.pose_outliers import pose_outliers
from omnimate.vehicle.arcs import integrate_twists
from omnimate.vehicle.linkage import follower, linkage_of
from omnimate.vehicle.parameters import JOINTS
from omnimate.vehicle.se2 import Array, between, wrap

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from omnimate.vehicle.parameters import Channel, TruckName
    from omnimate.vehicle.recording import Poses, Recording

WINDOW = 0.25  # [s] shorter than any manoeuvre
SHORTEST_SMOOTHING, SMOOTHING = 0.06, 0.2  # [s] shortest and longest time over which speeds are taken
LONGEST_SMOOTHING = 1.0  # [s] longest one where counts must not show in speeds: still shorter than manoeuvres
# [rad] turn that moves a reference by half of its offset from the axle: 2 sin(30 degrees / 2) = 0.52
MIN_TURN = math.radians(30.0)
MAX_SPEED_STEP = 5e-4  # [m/s] of a count: coarser encoders are smoothed longer, but lose sharp accelerations
START_ROUGHNESS = 3e-4  # [m/sqrt(m)] floor's roughness at which the estimation of noise starts
POSE_INTERVAL = 0.5  # [s] to which dense poses are thinned before the trajectory follows them


@dataclass(frozen=True, slots=True)
class Signals:
    """One recording as N - 1 steps of a robot of T trucks, and a trajectory."""

    recording: Recording
    # the steps of the nominal robot. Its readings are expected along the path: measured readings would put
    # the floor's noise on both sides of a regression on them
    block: Block
    path: Array  # poses of the trucks about which the model is linear, headings unwrapped, `(N, T, 3)`
    facing: Array  # cosine and sine of the headings between the samples, `(N - 1, T, 2)`
    # displacement of the trucks in the world by their wheels alone, `(N, T, 3)`: without the corrections by
    # which the noise of readings and poses enters the path
    driven: Array
    reading: Array  # joint_a, joint_b [rad] and link [m], `(N, 3)`; no columns with a single truck
    resolution: Array  # one count of each reading, `(3,)` [rad, rad, m]; empty with a single truck
    poses: Poses | None  # measured from outside, within the samples and in order of time; None without
    steady: tuple[Array, Array]  # speeds and accelerations of the wheels, see `smooth_block`

    @property
    def trucks(self) -> tuple[TruckName, ...]:
        """Names of the trucks."""
        return tuple(self.recording.vehicle.trucks)

    @property
    def wheels(self) -> tuple[Channel, ...]:
        """Names of the wheels."""
        return self.recording.vehicle.wheels

    @property
    def smooth_block(self) -> Block:
        """The steps with speeds and accelerations in which no single count shows.

        What is learned of a quantity would otherwise be learned of its rounding, which is in the data, too.
        """
        speed, acceleration = self.steady
        return replace(self.block, speed=speed, acceleration=acceleration)

    @property
    def time(self) -> Array:
        """Times of the samples, `(N,)` [s]."""
        return self.recording.time


def signals_of(recording: Recording) -> Signals:
    """Return the signals of a recording, about the trajectory of the nominal robot."""
    vehicle, time = recording.vehicle, recording.time
    period = np.diff(time)
    angles = [bridged(recording, wheel, recording.wheel_angle(wheel)) for wheel in vehicle.wheels]
    angle = np.stack(angles, axis=1)
    radius = np.concatenate([truck.radii for truck in vehicle.trucks.values()])
    wheelbase = np.array([truck.wheelbase for truck in vehicle.trucks.values()])
    turned = np.diff(angle, axis=0)
    count = max(abs(vehicle.metres_per_count(wheel)) for wheel in vehicle.wheels)
    smoothing = max(count / MAX_SPEED_STEP, SHORTEST_SMOOTHING)
    speed, acceleration = _rates(radius * angle, time, min(smoothing, SMOOTHING))
    steady = _rates(radius * angle, time, min(smoothing, LONGEST_SMOOTHING))
    reading = _readings(recording)
    travel = radius * turned
    yaw = (travel[:, 1::2] - travel[:, 0::2]) / wheelbase
    forward = 0.5 * (travel[:, 1::2] + travel[:, 0::2])
    nominal = np.stack([forward, np.zeros_like(yaw), yaw], axis=-1)
    poses = _usable(recording, nominal)
    path = _path(recording, nominal, reading, poses)
    heading, place, expected = _along_path(path)
    block = Block(
        time=time[1:],
        period=period,
        angle=angle[1:],
        turned=turned,
        speed=speed,
        acceleration=acceleration,
        wheelbase=wheelbase,
        heading=heading,
        place=place,
        travel=travel,
        twist=nominal,
        reading=expected,
        rest=0.0 if vehicle.linkage is None else vehicle.linkage.length,
    )
    resolution = np.array(
        [abs(vehicle.encoder(name).scale) for name in vehicle.expected_channels if name not in vehicle.wheels]
    )
    return Signals(recording, block, path, *_driven(heading, nominal), reading, resolution, poses, steady)


def about(signals: Signals, offset: Array, twist: Array) -> Signals:
    """Return the signals of a recording about another trajectory, by twists `(N - 1, T, 3)` of the trucks.

    It leaves out known errors of the linkage readings, `(N, 3)` [rad, rad, m].
    """
    path = _path(signals.recording, twist, signals.reading - offset, signals.poses)
    heading, place, expected = _along_path(path)
    facing, driven = _driven(heading, twist)
    block = replace(signals.block, heading=heading, place=place, reading=expected)
    return replace(signals, block=block, path=path, facing=facing, driven=driven)


def _along_path(path: Array) -> tuple[Array, Array, Array]:
    """Return headings (K, T), positions (K, T, 2) and expected readings (K, 3) in steps along a path."""
    middle = 0.5 * (path[1:] + path[:-1])
    if path.shape[1] == 1:
        return middle[:, :, 2], middle[:, :, :2], np.zeros((len(middle), 0))
    reading = expected_reading(path)
    reading[:, :2] = np.unwrap(reading[:, :2], axis=0)
    # Mean of the samples before and after: the path holds the rounding of the wheels at each sample, which is
    # in the data, too, and effects that depend on the reading would seem to explain it.
    reading[1:-1] = 0.5 * (reading[:-2] + reading[2:])
    return middle[:, :, 2], middle[:, :, :2], reading[1:]


def _driven(heading: Array, twist: Array) -> tuple[Array, Array]:
    """Return cosine and sine (K, T, 2) of headings, and the displacement (K + 1, T, 3) by twists."""
    facing = np.stack([np.cos(heading), np.sin(heading)], axis=-1)
    driven = np.zeros((len(twist) + 1, *twist.shape[1:]))
    driven[1:, :, 0] = facing[..., 0] * twist[..., 0] - facing[..., 1] * twist[..., 1]
    driven[1:, :, 1] = facing[..., 1] * twist[..., 0] + facing[..., 0] * twist[..., 1]
    driven[1:, :, 2] = twist[..., 2]
    return facing, np.cumsum(driven, axis=0)


def grid(time: Array) -> NDArray[np.int64]:
    """Return the samples at which windows end: evenly spaced in time, including the first and the last."""
    count = max(2, round((time[-1] - time[0]) / WINDOW))
    return np.unique(np.searchsorted(time, np.linspace(time[0], time[-1], count + 1)).clip(max=len(time) - 1))


def _rates(travel: Array, time: Array, smoothing: float) -> tuple[Array, Array]:
    """Return the smoothed speed [m/s] and acceleration [m/s^2] of wheels in each step, `(N - 1, W)`."""
    period = float(np.median(np.diff(time)))
    half = max(1, round(0.5 * smoothing / period))
    index = np.arange(len(time))
    before, after = np.maximum(index - half, 0), np.minimum(index + half, len(time) - 1)
    speed = (travel[after] - travel[before]) / np.maximum(time[after] - time[before], period)[:, None]
    acceleration = (speed[after] - speed[before]) / np.maximum(time[after] - time[before], period)[:, None]
    return 0.5 * (speed[1:] + speed[:-1]), 0.5 * (acceleration[1:] + acceleration[:-1])


def _readings(recording: Recording) -> Array:
    """Return joint_a, joint_b [rad] and link [m], `(N, 3)`; no columns without a linkage."""
    if recording.vehicle.linkage is None:
        return np.zeros((len(recording), 0))
    joints = [bridged(recording, joint, recording.joint_angle(joint)) for joint in JOINTS]
    return np.stack([*joints, bridged(recording, "link", recording.link_length())], axis=1)


def bridged(recording: Recording, channel: Channel, values: Array) -> Array:
    """Return a channel's values (N,), interpolated where frames are missing.

    With values held, a wheel would stand still for a sample, and then jump.
    """
    present = recording.is_present(channel)
    if present.all() or not present.any():
        return values
    return np.asarray(np.interp(recording.time, recording.time[present], values[present]))


def _usable(recording: Recording, twist: Array) -> Poses | None:
    """Return the poses within the recording's time, with outliers as unknown; None where none is known."""
    poses, time = recording.poses, recording.time
    if poses is None:
        return None
    known = np.isfinite(poses.pose).any(axis=1) & (poses.time >= time[0]) & (poses.time <= time[-1])
    poses = poses.select(known & np.isin(poses.body, list(recording.vehicle.trucks)))
    if not len(poses.time):
        return None
    poses = poses.select(np.argsort(poses.time, kind="stable"))
    pose = poses.pose.copy()
    for number, truck in enumerate(recording.vehicle.trucks):
        rows = np.flatnonzero(poses.body == truck)
        path = integrated(twist[:, number], np.zeros(3))
        driven = poses_at(poses.time[rows], time, path)
        pose[rows] = np.where(pose_outliers(pose[rows], driven), np.nan, pose[rows])
    return replace(poses, pose=pose).select(np.isfinite(pose).any(axis=1))


def poses_at(when: Array, time: Array, path: Array) -> Array:
    """Return the poses `(P, 3)` at times (P,) [s] on a path `(N, 3)`, interpolated between its times (N,)."""
    return np.stack([np.interp(when, time, axis) for axis in path.T], axis=1)


def _path(recording: Recording, twist: Array, reading: Array, poses: Poses | None) -> Array:
    """Return poses (N, T, 3) that depend on the past only, except where poses are sparse."""
    time = recording.time
    of_lead = None if poses is None else poses.of("a")
    if of_lead is None or not len(of_lead.time):
        lead = integrated(twist[:, 0], np.zeros(3))
    elif is_dense(of_lead):
        first = np.nan_to_num(of_lead.pose[0])
        first[2] = of_lead.pose[np.isfinite(of_lead.pose[:, 2]), 2][0]
        after = np.searchsorted(time, of_lead.time)
        lead = follow_poses(twist[:, 0].copy(), time, first, of_lead.time, of_lead.pose, after)
    else:
        lead = _between_poses(time, twist[:, 0], of_lead)
    if reading.shape[1] == 0:
        return lead[:, None, :]
    behind = between(lead, follower(lead, reading[:, 0], reading[:, 1], reading[:, 2]))
    return np.stack([lead, follow_linkage(lead, twist[:, 1].copy(), time, behind)], axis=1)


def is_turned(poses: Poses) -> bool:
    """Say whether enough whole poses are measured, and in different directions.

    The offset of a reference on its truck is not identifiable from a single heading. With the start it is
    six parameters: twice as many values have to be measured.
    """
    known = np.isfinite(poses.pose).all(axis=1)
    headings = poses.pose[known, 2]
    return headings.size >= 4 and bool(np.any(np.abs(wrap(headings - headings[0])) > MIN_TURN))


def is_dense(poses: Poses) -> bool:
    """Say whether whole poses are frequent enough for a path that depends on the past only."""
    known = np.isfinite(poses.pose).all(axis=1)
    return int(known.sum()) > 2 and float(np.median(np.diff(poses.time[known]))) < FORGETTING


def _between_poses(time: Array, twist: Array, poses: Poses) -> Array:
    """Return odometry (N, 3) of truck a, corrected by interpolation between sparse poses."""
    lead = integrated(twist, np.nan_to_num(poses.pose[0]))
    poses = _thinned(poses)
    known = np.isfinite(poses.pose)
    if known[:, 2].any():
        at = poses.time[known[:, 2]]
        error = np.unwrap(wrap(poses.pose[known[:, 2], 2] - np.interp(at, time, lead[:, 2])))
        turn = np.interp(time, at, error)
    else:
        turn = np.full(len(time), _direction(poses, time, lead))
    lead = integrate_twists(twist, lead[:, 2] + turn, lead[0])
    for axis in range(2):
        if known[:, axis].any():
            at = poses.time[known[:, axis]]
            error = poses.pose[known[:, axis], axis] - np.interp(at, time, lead[:, axis])
            lead[:, axis] += np.interp(time, at, error)
    return lead


def _thinned(poses: Poses) -> Poses:
    """Return poses no denser than a trajectory needs to follow them: the middle one of each interval."""
    interval = np.floor((poses.time - poses.time[0]) / POSE_INTERVAL).astype(int)
    first = np.flatnonzero(np.diff(interval, prepend=-1))
    return poses.select((first + np.append(first[1:], len(interval))) // 2)


def _direction(poses: Poses, time: Array, path: Array) -> float:
    """Return the rotation [rad] that aligns a path with measured positions."""
    known = np.isfinite(poses.pose[:, :2]).all(axis=1)
    if known.sum() < 2:
        return 0.0
    driven, measured = (
        place[:, 0] + 1j * place[:, 1]
        for place in (poses_at(poses.time[known], time, path), poses.pose[known])
    )
    return float(np.angle(np.vdot(driven - driven.mean(), measured - measured.mean())))


def integrated(twist: Array, start: Array) -> Array:
    """Return poses `(N, 3)` along N - 1 twists (forward [m], left [m], yaw [rad]) on exact arcs."""
    heading = np.concatenate(([start[2]], start[2] + np.cumsum(twist[:, 2])))
    return integrate_twists(twist, heading, start)


def expected_reading(path: Array) -> Array:
    """Return joint_a, joint_b [rad] and link [m] of an ideal linkage along a path `(N, 2, 3)`, `(N, 3)`."""
    return np.stack(linkage_of(path[:, 0], path[:, 1]), axis=-1)
