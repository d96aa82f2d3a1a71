"""A recording as the signals that effects act on, and the trajectory about which the model is linear."""

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

    from omnimate.vehicle.parameters import Channel, TruckName, VehicleParameters
    from omnimate.vehicle.recording import Poses, Recording

WINDOW = 0.25  # [s] shorter than any manoeuvre; what happens in one shows in the next reading
SMOOTHING = 0.06, 0.2  # [s] over which a wheel's speed is taken, at least and at most
TURNED = math.radians(30.0)  # by which half of what a reference is off shows as a change of place: 2 sin 15
FINE = 5e-4  # [m/s] of speed that a count may make; what is smoothed longer loses its sharp accelerations
# [m/sqrt(m)] a floor's roughness before the noise of a recording is estimated: where that search starts
START_ROUGHNESS = 3e-4
_COARSE = 0.5  # [s] into which dense poses are averaged before the trajectory follows them


@dataclass(frozen=True, slots=True)
class Signals:
    """One recording on its way through the diagnosis.

    Attributes:
        recording: itself.
        block: its N - 1 steps, as the nominal robot would have driven them. Its readings are those that
            odometry foresees from a moment before: what the floor's roughness adds to a reading would
            otherwise stand on both sides of a regression on readings.
        path: (N, T, 3) poses of the trucks about which the model is linear, headings unwrapped.
        facing: (N - 1, T, 2) cosine and sine of the headings between the samples.
        gone: (N, T, 3) way of the trucks in the world by their wheels alone, without what draws the path to
            readings and poses, and carries their noise into it.
        reading: (N, 3) of joint_a, joint_b [rad] and link [m]; no columns with a single truck.
        resolution: (3,) one count of each of them [rad, rad, m]; empty likewise.
        poses: measured from outside, in order of time and within the samples; empty without.
    """

    recording: Recording
    block: Block
    path: Array
    facing: Array
    gone: Array
    reading: Array
    resolution: Array
    poses: Poses | None

    @property
    def trucks(self) -> tuple[TruckName, ...]:
        """Names of the trucks."""
        return tuple(self.recording.vehicle.trucks)

    @property
    def time(self) -> Array:
        """Times of the samples, `(N,)` [s]."""
        return self.recording.time


def signals_of(recording: Recording) -> Signals:
    """Return a recording's signals, with all of its effects still in it."""
    vehicle, time = recording.vehicle, recording.time
    period = np.diff(time)
    angle = np.stack(
        [bridged(recording, wheel, recording.wheel_angle(wheel)) for wheel in vehicle.wheels], axis=1
    )
    radius = np.array([0.5 * vehicle.wheel_diameter(wheel) for wheel in vehicle.wheels])
    wheelbase = np.array([truck.wheelbase for truck in vehicle.trucks.values()])
    turned = np.diff(angle, axis=0)
    speed, acceleration = _rates(radius * angle, time, _smoothing(vehicle))
    reading = _readings(recording)
    travel = radius * turned
    yaw = (travel[:, 1::2] - travel[:, 0::2]) / wheelbase
    forward = 0.5 * (travel[:, 1::2] + travel[:, 0::2])
    nominal = np.stack([forward, np.zeros_like(yaw), yaw], axis=-1)
    poses = _usable(recording, nominal)
    path = _path(recording, nominal, reading, poses)
    heading, place, shown = _along_path(path)
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
        reading=shown,
        rest=0.0 if vehicle.linkage is None else vehicle.linkage.length,
    )
    resolution = np.array(
        [abs(vehicle.encoder(name).scale) for name in vehicle.channels if name not in vehicle.wheels]
    )
    facing, gone = _gone(heading, nominal)
    return Signals(recording, block, path, facing, gone, reading, resolution, poses)


def about(signals: Signals, offset: Array | float, twist: Array) -> Signals:
    """Return a recording's signals about another trajectory.

    Args:
        signals: Of the recording.
        offset: What is known of the linkage readings' errors, `(N, 3)` [rad, rad, m]: the trajectory is that
            of the readings without it.
        twist: Of the trucks, `(N - 1, T, 3)`.
    """
    path = _path(signals.recording, twist, signals.reading - offset, signals.poses)
    heading, place, shown = _along_path(path)
    facing, gone = _gone(heading, twist)
    block = replace(signals.block, heading=heading, place=place, reading=shown)
    return replace(signals, block=block, path=path, facing=facing, gone=gone)


def _along_path(path: Array) -> tuple[Array, Array, Array]:
    """Return headings, places and a perfect linkage's readings of K steps along a path (K + 1, T, 3)."""
    middle = 0.5 * (path[1:] + path[:-1])
    return middle[:, :, 2], middle[:, :, :2], _unwrapped_reading(path)[1:]


def _gone(heading: Array, twist: Array) -> tuple[Array, Array]:
    """Return the directions (K, T, 2) of headings, and the way (K + 1, T, 3) of trucks in the world."""
    facing = np.stack([np.cos(heading), np.sin(heading)], axis=-1)
    gone = np.zeros((len(twist) + 1, *twist.shape[1:]))
    gone[1:, :, 0] = facing[..., 0] * twist[..., 0] - facing[..., 1] * twist[..., 1]
    gone[1:, :, 1] = facing[..., 1] * twist[..., 0] + facing[..., 0] * twist[..., 1]
    gone[1:, :, 2] = twist[..., 2]
    return facing, np.cumsum(gone, axis=0)


def grid(time: Array) -> NDArray[np.int64]:
    """Return the samples, evenly spaced in time, at which windows end; the first and the last among them."""
    count = max(2, round((time[-1] - time[0]) / WINDOW))
    return np.unique(np.searchsorted(time, np.linspace(time[0], time[-1], count + 1)).clip(max=len(time) - 1))


def _unwrapped_reading(path: Array) -> Array:
    """Return the readings (N, 3) of a perfect linkage along a path, its joints unwrapped."""
    if path.shape[1] == 1:
        return np.zeros((len(path), 0))
    reading = expected_reading(path)
    reading[:, :2] = np.unwrap(reading[:, :2], axis=0)
    return reading


def _smoothing(vehicle: VehicleParameters) -> float:
    """Return the time over which speeds are taken [s]: long against a count, short against a servo."""
    count = max(abs(vehicle.metres_per_count(wheel)) for wheel in vehicle.wheels)
    return float(np.clip(count / FINE, *SMOOTHING))


def _rates(way: Array, time: Array, smoothing: float) -> tuple[Array, Array]:
    """Return the smoothed speed [m/s] and acceleration [m/s^2] of wheels in each step, `(N - 1, W)`."""
    period = float(np.median(np.diff(time)))
    half = max(1, round(0.5 * smoothing / period))
    index = np.arange(len(time))
    before, after = np.maximum(index - half, 0), np.minimum(index + half, len(time) - 1)
    speed = (way[after] - way[before]) / np.maximum(time[after] - time[before], period)[:, None]
    acceleration = (speed[after] - speed[before]) / np.maximum(time[after] - time[before], period)[:, None]
    return 0.5 * (speed[1:] + speed[:-1]), 0.5 * (acceleration[1:] + acceleration[:-1])


def _readings(recording: Recording) -> Array:
    if recording.vehicle.linkage is None:
        return np.zeros((len(recording), 0))
    joints = [bridged(recording, joint, recording.joint_angle(joint)) for joint in JOINTS]
    return np.stack([*joints, bridged(recording, "link", recording.link_length())], axis=1)


def bridged(recording: Recording, channel: Channel, values: Array) -> Array:
    """Return a channel's values (N,) with those of missing frames drawn between their neighbours.

    Held values would make a wheel stand still for a sample, and then jump.
    """
    there = recording.is_present(channel)
    if there.all() or not there.any():
        return values
    return np.asarray(np.interp(recording.time, recording.time[there], values[there]))


def _usable(recording: Recording, twist: Array) -> Poses | None:
    """Return the poses within the recording's time of which something is known, outliers being unknown.

    Args:
        recording: With the poses.
        twist: Of the trucks by their wheels, (N - 1, T, 3).
    """
    poses, time = recording.poses, recording.time
    if poses is None:
        return None
    known = np.isfinite(poses.pose).any(axis=1)
    known &= (
        (poses.time >= time[0])
        & (poses.time <= time[-1])
        & np.isin(poses.body, list(recording.vehicle.trucks))
    )
    if not known.any():
        return None
    order = np.flatnonzero(known)[np.argsort(poses.time[known], kind="stable")]
    when, body, pose = poses.time[order], poses.body[order], poses.pose[order]
    for number, truck in enumerate(recording.vehicle.trucks):
        mine = np.flatnonzero(body == truck)
        way = integrated(twist[:, number], np.zeros(3))
        driven = np.stack([np.interp(when[mine], time, way[:, axis]) for axis in range(3)], axis=1)
        pose[mine] = np.where(pose_outliers(pose[mine], driven), np.nan, pose[mine])
    known = np.isfinite(pose).any(axis=1)
    return type(poses)(when[known], body[known], pose[known], poses.sigma[order][known])


def _path(recording: Recording, twist: Array, reading: Array, poses: Poses | None) -> Array:
    """Return poses (N, T, 3) that know the past only, but for sparse measured poses."""
    time = recording.time
    own = None if poses is None else poses.of("a")
    first = np.zeros(3) if own is None else _start(own)
    if own is not None and is_dense(own):
        first[2] = own.pose[np.isfinite(own.pose[:, 2]), 2][0]
        after = np.searchsorted(time, own.time)
        lead = follow_poses(twist[:, 0].copy(), time, first, own.time, own.pose, after)
    else:
        lead = _between_poses(time, twist[:, 0], own, first)
    if reading.shape[1] == 0:
        return lead[:, None, :]
    behind = between(lead, follower(lead, reading[:, 0], reading[:, 1], reading[:, 2]))
    return np.stack([lead, follow_linkage(lead, twist[:, 1].copy(), time, behind)], axis=1)


def is_turned(poses: Poses) -> bool:
    """Say whether positions are measured together with headings that differ, and often enough.

    Where a reference sits on a truck does not show in a single direction. With where the truck began it is
    six numbers: twice as many have to be measured.
    """
    known = np.isfinite(poses.pose).all(axis=1)
    headings = poses.pose[known, 2]
    return headings.size >= 4 and bool(np.any(np.abs(wrap(headings - headings[0])) > TURNED))


def is_dense(poses: Poses) -> bool:
    """Say whether whole poses come often enough that a path need not look ahead to the next."""
    known = np.isfinite(poses.pose).all(axis=1)
    return int(known.sum()) > 2 and float(np.median(np.diff(poses.time[known]))) < FORGETTING


def _between_poses(time: Array, twist: Array, own: Poses | None, first: Array) -> Array:
    """Return odometry (N, 3) of truck a, drawn to poses that are measured now and then."""
    lead = integrated(twist, first)
    if own is None or len(own.time) == 0:
        return lead
    own = _averaged(own)
    heading = np.isfinite(own.pose[:, 2])
    if heading.any():
        at = own.time[heading]
        off = np.unwrap(wrap(own.pose[heading, 2] - np.interp(at, time, lead[:, 2])))
        turn = np.interp(time, at, off)
    else:
        turn = np.full(len(time), _direction(own, time, lead))
    lead = _along(lead, twist, turn)
    for axis in range(2):
        known = np.isfinite(own.pose[:, axis])
        if known.any():
            at = own.time[known]
            off = own.pose[known, axis] - np.interp(at, time, lead[:, axis])
            lead[:, axis] += np.interp(time, at, off)
    return lead


def _averaged(poses: Poses) -> Poses:
    """Return poses no denser than the trajectory needs to follow them: means over short stretches."""
    if len(poses.time) < 2:
        return poses
    stretch = np.floor((poses.time - poses.time[0]) / _COARSE).astype(int)
    _, group = np.unique(stretch, return_inverse=True)
    if group[-1] + 1 == len(poses.time):
        return poses
    middle = np.searchsorted(group, np.arange(group[-1] + 1))
    last = np.append(middle[1:], len(group))
    pick = (middle + last) // 2
    return type(poses)(poses.time[pick], poses.body[pick], poses.pose[pick], poses.sigma[pick])


def _direction(poses: Poses, time: Array, path: Array) -> float:
    """Return by how much to turn a path so that it runs as measured positions do [rad]."""
    known = np.isfinite(poses.pose[:, :2]).all(axis=1)
    if known.sum() < 2:
        return 0.0
    x, y = (np.interp(poses.time[known], time, path[:, axis]) for axis in range(2))
    driven, measured = x + 1j * y, poses.pose[known, 0] + 1j * poses.pose[known, 1]
    return float(np.angle(np.vdot(driven - driven.mean(), measured - measured.mean())))


def _start(poses: Poses) -> Array:
    """Return a start (3,) that is near the first poses; zero where nothing is known."""
    if len(poses.time) == 0:
        return np.zeros(3)
    return np.where(np.isfinite(poses.pose[0]), poses.pose[0], 0.0)


def integrated(twist: Array, start: Array) -> Array:
    """Return poses `(N, 3)` along N - 1 twists (forward [m], left [m], yaw [rad]) on exact arcs."""
    heading = np.concatenate(([start[2]], start[2] + np.cumsum(twist[:, 2])))
    return integrate_twists(twist, heading, start)


def _along(path: Array, twist: Array, turn: Array) -> Array:
    """Return a path turned at every sample by an angle (N,) [rad]."""
    return integrate_twists(twist, path[:, 2] + turn, path[0])


def expected_reading(path: Array) -> Array:
    """Return what a perfect linkage reads along a path `(N, 2, 3)`: joint_a, joint_b [rad], link [m]."""
    joint_a, joint_b, length = linkage_of(path[:, 0], path[:, 1])
    return np.stack([joint_a, joint_b, length], axis=-1)
