"""One recording as a linear model over short windows: transitions, observations, and where noise enters.

State, for T trucks: errors of their poses in the world (x, y, theta each), what the three linkage
encoders round off, what the W wheel encoders round off, and by how much each wheel's travel is off per
metre on this stretch of the floor. Windows end where the filter measures.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.mismatch.recording.signals import START_ROUGHNESS, WINDOW, expected_reading, grid
from omnimate.vehicle.arcs import twists_along, wheel_levers
from omnimate.vehicle.compiled import IntArray, compiled
from omnimate.vehicle.floor import floor_covariance
from omnimate.vehicle.se2 import Array, wrap

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from omnimate.mismatch.recording.signals import Signals
    from omnimate.vehicle.parameters import Channel

STARTING = 1.5  # [s] in which a truck takes up its plays and turns its castors
# [m, m, rad] by which that moves it: castors swing by their trail, some centimetres, and take the truck along
# by a part of that, on a wheelbase of some decimetres
PUSHED = np.array([1e-2, 1e-2, 3e-2])
UNSTATED = (0.003, 0.003, 0.003)  # [m, m, rad] of poses whose file states no sigma


@dataclass(frozen=True, slots=True)
class Windows:
    """The linear model of one recording with M windows, n states and R rows of measurements.

    Attributes:
        signals: of the recording.
        ends: (M + 1,) samples at which windows begin and end.
        transition: (M, n, n).
        links: (K, 2) rows and columns off the transitions' diagonal that are not zero.
        observe: (M + 1, R, n).
        measured: (M + 1, R) the data; nan where nothing was measured.
        drift: (M, 3 T) what odometry does otherwise than the trajectory.
        stated: (M + 1, R) variance of poses as their file states it; 0 for the linkage.
        floor: (M, 3 T, 3 T) process covariance of the poses for a roughness of 1 m/sqrt(m).
        creep: (M, 3 T, 3 T) likewise of sideways motion.
        sway: (M, 3 T, 3 T) likewise of trucks on their tyres, for 1 m/sqrt(s).
        rounding: (M, n, n) process covariance of the encoders' rounding.
        lever: (M, W, n) what a metre of a wheel's travel does to the state.
        rolled: (M, W) way of each wheel in each window, whatever its direction [m].
        stamps: of each truck the times of the poses (P,) [s], and the window's end (P,) at which each counts.
    """

    signals: Signals
    ends: NDArray[np.int64]
    transition: Array
    links: NDArray[np.int64]
    observe: Array
    measured: Array
    drift: Array
    stated: Array
    floor: Array
    creep: Array
    sway: Array
    rounding: Array
    lever: Array
    rolled: Array
    stamps: tuple[tuple[Array, NDArray[np.int64]], ...]

    @property
    def time(self) -> Array:
        """Times of the windows' ends, `(M + 1,)` [s]."""
        return self.signals.time[self.ends]

    @property
    def linkage(self) -> int:
        """Rows of the linkage: 3 or 0; the rows of poses follow, three for each truck."""
        return int(self.signals.reading.shape[1])

    def aged(self, truck: int, age: Callable[[Array], Array]) -> Array:
        """Return by how much poses (M + 1, 3) of a truck that are older than they say are elsewhere.

        Args:
            truck: Number of the truck.
            age: Function from times (P,) [s] to ages (P,) [s].
        """
        (when, at), way = self.stamps[truck], self.signals.gone[:, truck]
        then, count = when - age(when), np.maximum(np.bincount(at, minlength=len(self.ends)), 1)
        change = np.empty((len(self.ends), 3))
        for axis in range(3):
            gone = np.interp(then, self.signals.time, way[:, axis])
            gone -= np.interp(when, self.signals.time, way[:, axis])
            change[:, axis] = np.bincount(at, weights=gone, minlength=len(self.ends)) / count
        return change


def windows_of(signals: Signals, dense: Sequence[tuple[float, float]] = ()) -> Windows:
    """Return the linear model of a recording.

    Args:
        signals: of the recording.
        dense: stretches of time (start, end) [s] in which every sample is measured, to see an event by.
    """
    ends = _ends(signals, dense)
    trucks, wheels, linkage = len(signals.trucks), 2 * len(signals.trucks), signals.reading.shape[1]
    states, count = 3 * trucks + linkage + 2 * wheels, len(ends) - 1
    path = signals.path[ends]
    lever = _lever(signals, ends, states)
    rolled = np.add.reduceat(np.abs(signals.block.travel), ends[:-1], axis=0)
    transition = np.tile(np.eye(states), (count, 1, 1))
    rounding = np.zeros((count, states, states))
    for truck in range(trucks):
        gone = np.diff(path[:, truck, :2], axis=0)
        transition[:, 3 * truck, 3 * truck + 2] = -gone[:, 1]
        transition[:, 3 * truck + 1, 3 * truck + 2] = gone[:, 0]
    _round_linkage(signals, ends, 3 * trucks, transition, rounding)
    _round_wheels(signals, rolled, lever, 3 * trucks + linkage, transition, rounding)
    _start_and_stop(signals, ends, rolled, rounding)
    waves = np.arange(states - wheels, states)
    transition[:, :, waves] += (rolled[:, :, None] * lever).transpose(0, 2, 1)
    floor, creep = _rough(rolled, lever), _creep(signals, ends, rolled)
    rolling = np.diff(signals.time[ends])[:, None] * (rolled > 0.0)
    sway = _rough(rolling, lever) + _creep(signals, ends, rolling)
    measured, stated, observe = _measurements(signals, ends, states)
    stamps = tuple(_stamps(signals, ends, truck) for truck in signals.trucks)
    drift = pushed(signals, ends, signals.block.twist - twists_along(signals.path))
    off = np.any(transition != 0.0, axis=0) & ~np.eye(states, dtype=bool)
    return Windows(
        signals,
        ends,
        transition,
        np.argwhere(off),
        observe,
        measured,
        drift,
        stated,
        floor,
        creep,
        sway,
        rounding,
        lever,
        rolled,
        stamps,
    )


def _start_and_stop(signals: Signals, ends: NDArray[np.int64], rolled: Array, rounding: Array) -> None:
    """Let trucks be pushed while they begin to drive, and while they come to a stand at the end.

    Nobody knows how castors stood and plays lay before, and a robot that brakes slides and nods.
    """
    moving = np.flatnonzero(rolled.max(axis=1) > 1e-3)
    if len(moving) == 0:
        return
    time = signals.time[ends[:-1]]
    first, last = time[moving[0]], time[moving[-1]]
    for begun in (
        np.flatnonzero((time >= first) & (time < first + STARTING)),
        np.flatnonzero((time > last - STARTING) & (time <= last + STARTING)),
    ):
        for truck in range(len(signals.trucks)):
            own = slice(3 * truck, 3 * truck + 3)
            rounding[begun, own, own] += np.diag(PUSHED**2) / max(len(begun), 1)


def _ends(signals: Signals, dense: Sequence[tuple[float, float]]) -> NDArray[np.int64]:
    """Return the samples at which windows end: evenly spaced, and where sparse poses were measured.

    No window ends where a wheel's frame is missing: what is drawn between its neighbours is no reading.
    """
    recording, time = signals.recording, signals.time
    ends = set(grid(time).tolist())
    if signals.poses is not None and _sparse(signals.poses.time, time[-1] - time[0]):
        nearest = np.searchsorted(time, signals.poses.time)
        ends |= set(np.clip(nearest, 0, len(time) - 1).tolist())
    for start, end in dense:
        inside = recording.between(start, end)
        ends |= set(range(inside.start, inside.stop))
    wheels = [recording.is_present(wheel) for wheel in recording.vehicle.wheels]
    whole = np.flatnonzero(np.logical_and.reduce(wheels))
    wanted = np.array(sorted(ends), np.int64)
    if len(whole) < 2:
        return wanted
    at = np.searchsorted(0.5 * (whole[1:] + whole[:-1]), wanted)
    return np.unique(whole[at])


def _sparse(times: Array, span: float) -> bool:
    return len(times) * WINDOW < span


def pushed(signals: Signals, ends: NDArray[np.int64], twist: Array) -> Array:
    """Return the inputs `(M, 3 T)`, of the poses, that additional twists `(K, T, 3)` are.

    Each yaw turns what follows it in its window.

    Args:
        signals: Of the recording.
        ends: Samples at which M windows begin and end, shape `(M + 1,)`.
        twist: In the K steps from the first to the last of these samples.
    """
    first, last = int(ends[0]), int(ends[-1])
    path, facing = signals.path[first : last + 1], signals.facing[first:last]
    return _pushed(path, facing, ends - first, np.ascontiguousarray(twist))


@compiled
def _pushed(path: Array, facing: Array, ends: IntArray, twist: Array) -> Array:
    """Do as `pushed`, of the poses (N, T, 3) and the directions (N - 1, T, 2) in which trucks look."""
    inputs = np.zeros((len(ends) - 1, 3 * twist.shape[1]))
    for window in range(len(ends) - 1):
        last = ends[window + 1]
        for step in range(ends[window], last):
            for truck in range(twist.shape[1]):
                ahead, aside, yaw = twist[step, truck]
                if ahead == 0.0 and aside == 0.0 and yaw == 0.0:
                    continue
                cos, sin = facing[step, truck]
                x = path[last, truck, 0] - 0.5 * (path[step + 1, truck, 0] + path[step, truck, 0])
                y = path[last, truck, 1] - 0.5 * (path[step + 1, truck, 1] + path[step, truck, 1])
                inputs[window, 3 * truck] += cos * ahead - sin * aside - yaw * y
                inputs[window, 3 * truck + 1] += sin * ahead + cos * aside + yaw * x
                inputs[window, 3 * truck + 2] += yaw
    return inputs


def pushed_by_curves(signals: Signals, ends: NDArray[np.int64], twist: Array, curves: Array) -> Array:
    """Return the inputs `(M, 3 T, B)` that additional twists `(N - 1, T, 3)` are, times each of B curves.

    Args:
        signals: Of the recording.
        ends: Samples at which M windows begin and end, shape `(M + 1,)`.
        twist: In each step, where a curve is one.
        curves: In each step, `(N - 1, B)`.
    """
    begin, end = int(ends[0]), int(ends[-1])  # a sample without all wheels is no end of a window
    path, facing, twist = signals.path[begin : end + 1], signals.facing[begin:end], twist[begin:end]
    last = np.repeat(ends[1:], np.diff(ends)) - begin
    x, y = np.moveaxis(path[last, :, :2] - 0.5 * (path[1:, :, :2] + path[:-1, :, :2]), 2, 0)
    (ahead, aside, yaw), (cos, sin) = np.moveaxis(twist, 2, 0), np.moveaxis(facing, 2, 0)
    pushes = np.stack(
        [cos * ahead - sin * aside - yaw * y, sin * ahead + cos * aside + yaw * x, yaw], axis=2
    ).reshape(len(twist), -1)
    return _summed(pushes, np.ascontiguousarray(curves[begin:end]), ends - begin)


@compiled
def _summed(pushes: Array, curves: Array, ends: IntArray) -> Array:
    """Return pushes (K, R) times curves (K, B), summed over the steps of each window: `(M, R, B)`."""
    inputs = np.zeros((len(ends) - 1, pushes.shape[1], curves.shape[1]))
    for window in range(len(ends) - 1):
        for step in range(ends[window], ends[window + 1]):
            for row in range(pushes.shape[1]):
                if pushes[step, row] != 0.0:
                    for curve in range(curves.shape[1]):
                        inputs[window, row, curve] += pushes[step, row] * curves[step, curve]
    return inputs


def _lever(signals: Signals, ends: NDArray[np.int64], states: int) -> Array:
    """Return what a metre of a wheel's travel in the middle of each window does, (M, W, n)."""
    path, block = signals.path, signals.block
    lever = np.zeros((len(ends) - 1, 2 * len(signals.trucks), states))
    middle = (ends[1:] + ends[:-1]) // 2
    for truck in range(len(signals.trucks)):
        heading = path[middle, truck, 2]
        lag = path[ends[1:], truck, :2] - path[middle, truck, :2]
        own, both = slice(3 * truck, 3 * truck + 3), slice(2 * truck, 2 * truck + 2)
        lever[:, both, own] = wheel_levers(heading, lag, block.wheelbase[truck]).transpose(0, 2, 1)
    return lever


def _rough(rolled: Array, lever: Array) -> Array:
    """Return the covariances (M, 3 T, 3 T) of wheels that are off by the root of what each rolls (M, W)."""
    trucks = lever.shape[1] // 2
    covariance = np.zeros((len(lever), 3 * trucks, 3 * trucks))
    for truck in range(trucks):
        own, both = slice(3 * truck, 3 * truck + 3), slice(2 * truck, 2 * truck + 2)
        covariance[:, own, own] = floor_covariance(lever[:, both, own].transpose(0, 2, 1), rolled[:, both])
    return covariance


def _creep(signals: Signals, ends: NDArray[np.int64], rolled: Array) -> Array:
    poses = 3 * len(signals.trucks)
    covariance = np.zeros((len(ends) - 1, poses, poses))
    middle = (ends[1:] + ends[:-1]) // 2
    for truck in range(len(signals.trucks)):
        heading = signals.path[middle, truck, 2]
        side = np.stack([-np.sin(heading), np.cos(heading)], axis=1)
        way = 0.5 * (rolled[:, 2 * truck] + rolled[:, 2 * truck + 1])
        own = slice(3 * truck, 3 * truck + 2)
        covariance[:, own, own] = way[:, None, None] * side[:, :, None] * side[:, None, :]
    return covariance


def _round_linkage(
    signals: Signals, ends: NDArray[np.int64], first: int, transition: Array, rounding: Array
) -> None:
    """Let what a linkage encoder rounds off last until the linkage has moved by a count.

    It moves by what is read, and on any floor by its roughness, while the reading may stand still.
    """
    if not signals.reading.shape[1]:
        return
    rolled = np.add.reduceat(np.abs(signals.block.travel).mean(axis=1), ends[:-1])
    jitter = START_ROUGHNESS * np.sqrt(rolled)
    turning = jitter[:, None] * np.sqrt(2.0) / signals.block.wheelbase
    moved = np.abs(np.diff(signals.reading[ends], axis=0)) + np.column_stack([turning, jitter])
    kept = np.exp(-3.0 * moved / signals.resolution)
    for channel in range(3):
        transition[:, first + channel, first + channel] = kept[:, channel]
        rounding[:, first + channel, first + channel] = (1.0 - kept[:, channel] ** 2) * (
            signals.resolution[channel] ** 2 / 12.0
        )


def _round_wheels(
    signals: Signals, rolled: Array, lever: Array, first: int, transition: Array, rounding: Array
) -> None:
    """Let what a wheel encoder rounds off come back in the next window; where it counts not, nothing is.

    A wheel that comes to stand on the edge of a count is counted to and fro: it is off by half of one.
    """
    vehicle = signals.recording.vehicle
    for number, wheel in enumerate(vehicle.wheels):
        count = abs(vehicle.metres_per_count(wheel))
        moving = np.flatnonzero(rolled[:, number] > 0.5 * count)
        variance = np.where(rolled[moving, number] > 2.5 * count, 1.0 / 12.0, 0.25) * count**2
        truck, own = slice(number // 2 * 3, number // 2 * 3 + 3), first + number
        push = lever[moving, number, truck]
        transition[moving, truck, own] += push
        transition[moving, own, own] = 0.0
        across = -variance[:, None] * push
        rounding[moving, truck, truck] += variance[:, None, None] * push[:, :, None] * push[:, None, :]
        rounding[moving, truck, own] += across
        rounding[moving, own, truck] += across
        rounding[moving, own, own] += variance


def _measurements(signals: Signals, ends: NDArray[np.int64], states: int) -> tuple[Array, Array, Array]:
    """Return measured, stated variance (M + 1, R each) and observation (M + 1, R, n)."""
    trucks, linkage = len(signals.trucks), signals.reading.shape[1]
    rows, path = linkage + 3 * trucks, signals.path[ends]
    measured, stated = np.full((len(ends), rows), np.nan), np.zeros((len(ends), rows))
    observe = np.zeros((len(ends), rows, states))
    if linkage:
        off = signals.reading[ends] - expected_reading(path)
        off[:, :2] = wrap(off[:, :2])
        channels: tuple[Channel, ...] = ("joint_a", "joint_b", "link")
        there = np.stack([signals.recording.is_present(channel)[ends] for channel in channels], axis=1)
        measured[:, :3] = np.where(there, off, np.nan)
        observe[:, :3, :6] = _linkage_rows(path)
        observe[:, range(3), range(6, 9)] = 1.0
    observe[:, linkage:, : 3 * trucks] = np.eye(3 * trucks)
    if signals.poses is not None:
        for number, truck in enumerate(signals.trucks):
            own = slice(linkage + 3 * number, linkage + 3 * number + 3)
            measured[:, own], stated[:, own] = _pose_rows(signals, ends, truck, number)
    return measured, stated, observe


def _linkage_rows(path: Array) -> Array:
    """Return the derivatives (M + 1, 3, 6) of joint_a, joint_b and link by the trucks' poses."""
    gap = path[:, 0, :2] - path[:, 1, :2]
    length = np.hypot(gap[:, 0], gap[:, 1])
    cos, sin = gap[:, 0] / length, gap[:, 1] / length
    rows = np.zeros((len(path), 3, 6))
    across = np.stack([-sin, cos], axis=1) / length[:, None]
    for joint in range(2):
        rows[:, joint, 0:2], rows[:, joint, 3:5] = -across, across
        rows[:, joint, 3 * joint + 2] = 1.0
    rows[:, 2, 0:2] = np.stack([cos, sin], axis=1)
    rows[:, 2, 3:5] = -rows[:, 2, 0:2]
    return rows


def _pose_rows(signals: Signals, ends: NDArray[np.int64], truck: str, number: int) -> tuple[Array, Array]:
    """Return what a truck's poses say beyond the path at each end, and their variances, (M + 1, 3)."""
    assert signals.poses is not None
    own = signals.poses.body == truck
    pose, sigma = signals.poses.pose[own], signals.poses.sigma[own]
    time, at = _stamps(signals, ends, truck)
    path = signals.path[:, number]
    off = pose - np.stack([np.interp(time, signals.time, path[:, axis]) for axis in range(3)], axis=1)
    off[:, 2] = wrap(off[:, 2])
    stated = np.where(np.isfinite(sigma) & (sigma > 0.0), sigma, UNSTATED) ** 2
    return _means(off, stated, at, len(ends))


def _stamps(signals: Signals, ends: NDArray[np.int64], truck: str) -> tuple[Array, NDArray[np.int64]]:
    """Return the times of a truck's poses, and the window's end at which each counts: the nearest one."""
    if signals.poses is None:
        return np.zeros(0), np.zeros(0, np.int64)
    moments = signals.time[ends]
    time = signals.poses.time[signals.poses.body == truck]
    return time, np.searchsorted(0.5 * (moments[1:] + moments[:-1]), time)


def _means(off: Array, stated: Array, group: NDArray[np.int64], count: int) -> tuple[Array, Array]:
    """Return the means (count, 3) of poses about each moment, and their variances."""
    known = np.isfinite(off)
    total, weight, variance = np.zeros((count, 3)), np.zeros((count, 3)), np.zeros((count, 3))
    np.add.at(total, group, np.where(known, off, 0.0))
    np.add.at(weight, group, known)
    np.add.at(variance, group, np.where(known, stated, 0.0))
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(weight > 0, total / weight, np.nan), np.where(weight > 0, variance / weight**2, 1.0)
