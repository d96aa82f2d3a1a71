"""One recording as a linear model over short windows: transitions, observations, and process noise.

State, for T trucks: errors of their poses in the world (x, y, theta each), rounding errors of the three
linkage encoders and of the W wheel encoders, and the relative error of each wheel's travel that the floor's
waves cause. Windows end where the filter measures.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from omnimate.effects.block import LINKAGE
from omnimate.mismatch.recording.signals import START_ROUGHNESS, WINDOW, expected_reading, grid, poses_at
from omnimate.vehicle.arcs import twists_along, wheel_levers
from omnimate.vehicle.compiled import IntArray, compiled
from omnimate.vehicle.floor import floor_covariance
from omnimate.vehicle.parameters import JOINTS
from omnimate.vehicle.se2 import Array, wrap

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from omnimate.mismatch.recording.signals import Signals
    from omnimate.vehicle.parameters import TruckName

STARTUP_TIME = 1.5  # [s] after which backlash is taken up and castors have turned; assumed
# [m, m, rad] standard deviation of the motion that this causes: castors swing by their trail of some
# centimetres, and move a truck with a wheelbase of some decimetres by a part of that. Assumed.
STARTUP_SIGMA = np.array([1e-2, 1e-2, 3e-2])
DEFAULT_POSE_SIGMA = (0.003, 0.003, 0.003)  # [m, m, rad] of poses whose file states none; assumed


@dataclass(frozen=True, slots=True)
class Windows:
    """The linear model of one recording with M windows, n states and R rows of measurements."""

    signals: Signals
    ends: NDArray[np.int64]  # samples at which windows begin and end, `(M + 1,)`
    transition: Array  # F, `(M, n, n)`
    links: NDArray[np.int64]  # rows and columns off the transitions' diagonal that are not zero, `(K, 2)`
    observe: Array  # H, `(M + 1, R, n)`
    measured: Array  # measured minus expected along the path; nan where nothing was measured, `(M + 1, R)`
    drift: Array  # difference of odometry to the trajectory, `(M, 3 T)`
    stated: Array  # variance of poses as their file states it; 0 for the linkage, `(M + 1, R)`
    floor: Array  # process covariance of the poses for a roughness of 1 m/sqrt(m), `(M, 3 T, 3 T)`
    creep: Array  # likewise of sideways motion, `(M, 3 T, 3 T)`
    sway: Array  # likewise of trucks on their tyres, for 1 m/sqrt(s), `(M, 3 T, 3 T)`
    rounding: Array  # process covariance of the encoders' rounding, and of starts and stops, `(M, n, n)`
    lever: Array  # derivative of the state by the travel of each wheel, `(M, W, n)`
    rolled: Array  # distance that each wheel rolls in each window, in either direction, `(M, W)` [m]
    stamps: tuple[tuple[Array, NDArray[np.int64]], ...]  # of poses: times (P,) [s], nearest ends (P,)

    @property
    def time(self) -> Array:
        """Times of the windows' ends, `(M + 1,)` [s]."""
        return self.signals.time[self.ends]

    @property
    def linkage(self) -> int:
        """Number of rows of the linkage, 3 or 0; the rows of poses follow, three for each truck."""
        return int(self.signals.reading.shape[1])

    @property
    def names(self) -> list[str]:
        """What the rows of measurements are called."""
        poses = [f"{truck}.{axis}" for truck in self.signals.trucks for axis in ("x", "y", "theta")]
        return [*LINKAGE[: self.linkage], *poses]

    def at_ends(self, steps: Array) -> Array:
        """Return the values of steps `(N - 1, ...)` at the windows' ends, `(M + 1, ...)`."""
        return np.asarray(steps[np.maximum(self.ends - 1, 0)])

    def thinned(self, stretch: float) -> Windows:
        """Return windows in which each row is measured once in a stretch [s], and open loop in between."""
        starts, thin = np.arange(self.time[0], self.time[-1], stretch), np.full_like(self.measured, np.nan)
        for row, values in enumerate(self.measured.T):
            known = np.append(np.flatnonzero(np.isfinite(values)), len(values) - 1)
            kept = known[np.searchsorted(self.time[known], starts)]
            thin[kept, row] = values[kept]
        return replace(self, measured=thin)

    def pose_rows(self, truck: int) -> slice:
        """Return the rows of the pose of a truck, by its number."""
        return slice(self.linkage + 3 * truck, self.linkage + 3 * truck + 3)

    def aged(self, truck: int, age: Callable[[Array], Array]) -> Array:
        """Return errors (M + 1, 3) of a truck's poses that are older than their stamps (P,) by an age [s]."""
        (stamp, end), path = self.stamps[truck], self.signals.driven[:, truck]
        taken, count = stamp - age(stamp), np.maximum(np.bincount(end, minlength=len(self.ends)), 1)
        moved = poses_at(taken, self.signals.time, path) - poses_at(stamp, self.signals.time, path)
        sums = [np.bincount(end, weights=axis, minlength=len(self.ends)) for axis in moved.T]
        return np.stack(sums, axis=1) / count[:, None]


def windows_of(signals: Signals) -> Windows:
    """Return the linear model of a recording."""
    ends = _ends(signals)
    trucks, wheels, linkage = len(signals.trucks), 2 * len(signals.trucks), signals.reading.shape[1]
    states, count = 3 * trucks + linkage + 2 * wheels, len(ends) - 1
    path = signals.path[ends]
    lever = _lever(signals, ends, states)
    rolled = np.add.reduceat(np.abs(signals.block.travel), ends[:-1], axis=0)
    transition = np.tile(np.eye(states), (count, 1, 1))
    rounding = np.zeros((count, states, states))
    for truck in range(trucks):
        x, y = np.diff(path[:, truck, :2], axis=0).T
        transition[:, 3 * truck, 3 * truck + 2] = -y
        transition[:, 3 * truck + 1, 3 * truck + 2] = x
    _round_linkage(signals, ends, 3 * trucks, transition, rounding)
    _round_wheels(signals, rolled, lever, 3 * trucks + linkage, transition, rounding)
    _start_and_stop(signals, ends, rolled, rounding)
    transition[:, :, states - wheels :] += (rolled[:, :, None] * lever).transpose(0, 2, 1)
    rolling = np.diff(signals.time[ends])[:, None] * (rolled > 0.0)
    measured, stated, observe = _measurements(signals, ends, states)
    drift = signals.block.twist - twists_along(signals.path)
    off_diagonal = np.any(transition != 0.0, axis=0) & ~np.eye(states, dtype=bool)
    return Windows(
        signals=signals,
        ends=ends,
        transition=transition,
        links=np.argwhere(off_diagonal),
        observe=observe,
        measured=measured,
        drift=pushed(signals, ends, drift[ends[0] : ends[-1]]),
        stated=stated,
        floor=_rough(rolled, lever),
        creep=_creep(signals, ends, rolled),
        sway=_rough(rolling, lever) + _creep(signals, ends, rolling),
        rounding=rounding,
        lever=lever,
        rolled=rolled,
        stamps=tuple(_stamps(signals, ends, truck) for truck in signals.trucks),
    )


def _start_and_stop(signals: Signals, ends: NDArray[np.int64], rolled: Array, rounding: Array) -> None:
    """Add process noise to the poses while the robot starts, and while it comes to a final stop.

    Castor angles and backlash are unknown at the start, and a robot that brakes slides and pitches.
    """
    moving = np.flatnonzero(rolled.max(axis=1) > 1e-3)
    if len(moving) == 0:
        return
    time = signals.time[ends[:-1]]
    first, last = time[moving[0]], time[moving[-1]]
    for affected in (
        np.flatnonzero((time >= first) & (time < first + STARTUP_TIME)),
        np.flatnonzero((time > last - STARTUP_TIME) & (time <= last + STARTUP_TIME)),
    ):
        for truck in range(len(signals.trucks)):
            pose = slice(3 * truck, 3 * truck + 3)
            rounding[affected, pose, pose] += np.diag(STARTUP_SIGMA**2) / max(len(affected), 1)


def _ends(signals: Signals) -> NDArray[np.int64]:
    """Return the samples at which windows end: evenly spaced, and where sparse poses were measured.

    No window ends where a wheel's frame is missing: an interpolated angle is no reading.
    """
    recording, time = signals.recording, signals.time
    wanted = [grid(time)]
    if signals.poses is not None and len(signals.poses.time) * WINDOW < time[-1] - time[0]:
        wanted.append(np.searchsorted(time, signals.poses.time).clip(max=len(time) - 1))
    ends = np.unique(np.concatenate(wanted))
    present = np.logical_and.reduce([recording.is_present(wheel) for wheel in recording.vehicle.wheels])
    complete = np.flatnonzero(present)
    if len(complete) < 2:
        return ends
    return np.unique(complete[np.searchsorted(0.5 * (complete[1:] + complete[:-1]), ends)])


def pushed(signals: Signals, ends: NDArray[np.int64], twist: Array) -> Array:
    """Return inputs (M, 3 T) to poses by more twists (K, T, 3) from the first to the last window's end."""
    return _pushed(signals, ends, twist, np.ones((len(twist), 1)))[:, :, 0]


def pushed_by_curves(signals: Signals, ends: NDArray[np.int64], twist: Array, curves: Array) -> Array:
    """Return inputs (M, 3 T, B) by more twists (N - 1, T, 3), times each of B curves (N - 1, B)."""
    steps = slice(int(ends[0]), int(ends[-1]))  # a sample without all wheels ends no window
    return _pushed(signals, ends, twist[steps], np.ascontiguousarray(curves[steps]))


def _pushed(signals: Signals, ends: NDArray[np.int64], twist: Array, curves: Array) -> Array:
    first, last = int(ends[0]), int(ends[-1])
    path, facing = signals.path[first : last + 1], signals.facing[first:last]
    return _summed(path, facing, np.ascontiguousarray(twist), curves, ends - first)


@compiled
def _summed(path: Array, facing: Array, twist: Array, curves: Array, ends: IntArray) -> Array:
    """Return by how much twists (K, T, 3), times curves (K, B), move poses at windows' ends, `(M, 3 T, B)`.

    A yaw also turns the rest of the window's path (K + 1, T, 3) about the middle of its step. `facing` are
    cosine and sine of the heading in each step, `(K, T, 2)`.
    """
    sums = np.zeros((len(ends) - 1, 3 * twist.shape[1], curves.shape[1]))
    moved = np.zeros(3)
    for window in range(len(ends) - 1):
        end = path[ends[window + 1]]
        for step in range(ends[window], ends[window + 1]):
            for truck in range(twist.shape[1]):
                ahead, aside, yaw = twist[step, truck, 0], twist[step, truck, 1], twist[step, truck, 2]
                cos, sin = facing[step, truck, 0], facing[step, truck, 1]
                x = end[truck, 0] - 0.5 * (path[step + 1, truck, 0] + path[step, truck, 0])
                y = end[truck, 1] - 0.5 * (path[step + 1, truck, 1] + path[step, truck, 1])
                moved[0] = cos * ahead - sin * aside - yaw * y
                moved[1] = sin * ahead + cos * aside + yaw * x
                moved[2] = yaw
                for axis in range(3):
                    if moved[axis] != 0.0:
                        for curve in range(curves.shape[1]):
                            sums[window, 3 * truck + axis, curve] += moved[axis] * curves[step, curve]
    return sums


def _lever(signals: Signals, ends: NDArray[np.int64], states: int) -> Array:
    """Return the derivatives `(M, W, n)` of the state by a wheel's travel in the middle of each window."""
    path, block = signals.path, signals.block
    lever = np.zeros((len(ends) - 1, 2 * len(signals.trucks), states))
    middle = (ends[1:] + ends[:-1]) // 2
    for truck in range(len(signals.trucks)):
        heading = path[middle, truck, 2]
        lag = path[ends[1:], truck, :2] - path[middle, truck, :2]
        pose, wheels = slice(3 * truck, 3 * truck + 3), slice(2 * truck, 2 * truck + 2)
        lever[:, wheels, pose] = wheel_levers(heading, lag, block.wheelbase[truck]).transpose(0, 2, 1)
    return lever


def _rough(rolled: Array, lever: Array) -> Array:
    """Return the pose covariances `(M, 3 T, 3 T)` of wheels whose travel has variances `rolled` (M, W)."""
    trucks = lever.shape[1] // 2
    covariance = np.zeros((len(lever), 3 * trucks, 3 * trucks))
    for truck in range(trucks):
        pose, wheels = slice(3 * truck, 3 * truck + 3), slice(2 * truck, 2 * truck + 2)
        levers = lever[:, wheels, pose].transpose(0, 2, 1)
        covariance[:, pose, pose] = floor_covariance(levers, rolled[:, wheels])
    return covariance


def _creep(signals: Signals, ends: NDArray[np.int64], rolled: Array) -> Array:
    """Return the covariances `(M, 3 T, 3 T)` of trucks that move sideways, by a variance of their travel."""
    poses = 3 * len(signals.trucks)
    covariance = np.zeros((len(ends) - 1, poses, poses))
    middle = (ends[1:] + ends[:-1]) // 2
    for truck in range(len(signals.trucks)):
        heading = signals.path[middle, truck, 2]
        side = np.stack([-np.sin(heading), np.cos(heading)], axis=1)
        distance = 0.5 * (rolled[:, 2 * truck] + rolled[:, 2 * truck + 1])
        place = slice(3 * truck, 3 * truck + 2)
        covariance[:, place, place] = distance[:, None, None] * side[:, :, None] * side[:, None, :]
    return covariance


def _round_linkage(
    signals: Signals, ends: NDArray[np.int64], first: int, transition: Array, rounding: Array
) -> None:
    """Model the rounding error of linkage encoders as a process that decorrelates within a count of motion.

    The linkage moves by the change of its reading, and on any floor by its roughness, even while the reading
    is constant.
    """
    if not signals.reading.shape[1]:
        return
    rolled = np.add.reduceat(np.abs(signals.block.travel).mean(axis=1), ends[:-1])
    jitter = START_ROUGHNESS * np.sqrt(rolled)
    turning = jitter[:, None] * np.sqrt(2.0) / signals.block.wheelbase
    moved = np.abs(np.diff(signals.reading[ends], axis=0)) + np.column_stack([turning, jitter])
    decay = np.exp(-3.0 * moved / signals.resolution)
    states = np.arange(first, first + 3)
    transition[:, states, states] = decay
    rounding[:, states, states] = (1.0 - decay**2) * (signals.resolution**2 / 12.0)


def _round_wheels(
    signals: Signals, rolled: Array, lever: Array, first: int, transition: Array, rounding: Array
) -> None:
    """Model the rounding errors of wheel encoders: each window's travel has that of its end, less the last.

    A wheel that does not count has no new one. A wheel that stops on the edge of a count is counted to and
    fro, and has an error of half a count.
    """
    vehicle = signals.recording.vehicle
    for number, wheel in enumerate(vehicle.wheels):
        count = abs(vehicle.metres_per_count(wheel))
        moving = np.flatnonzero(rolled[:, number] > 0.5 * count)
        variance = np.where(rolled[moving, number] > 2.5 * count, 1.0 / 12.0, 0.25) * count**2
        pose, state = slice(number // 2 * 3, number // 2 * 3 + 3), first + number
        push = lever[moving, number, pose]
        transition[moving, pose, state] += push
        transition[moving, state, state] = 0.0
        covariance = -variance[:, None] * push
        rounding[moving, pose, pose] += variance[:, None, None] * push[:, :, None] * push[:, None, :]
        rounding[moving, pose, state] += covariance
        rounding[moving, state, pose] += covariance
        rounding[moving, state, state] += variance


def _measurements(signals: Signals, ends: NDArray[np.int64], states: int) -> tuple[Array, Array, Array]:
    """Return measured, stated variance (M + 1, R each) and observation (M + 1, R, n)."""
    trucks, linkage = len(signals.trucks), signals.reading.shape[1]
    rows, path = linkage + 3 * trucks, signals.path[ends]
    measured, stated = np.full((len(ends), rows), np.nan), np.zeros((len(ends), rows))
    observe = np.zeros((len(ends), rows, states))
    if linkage:
        error = signals.reading[ends] - expected_reading(path)
        error[:, :2] = wrap(error[:, :2])
        recording = signals.recording
        present = np.stack([recording.is_present(name)[ends] for name in (*JOINTS, "link")], axis=1)
        measured[:, :3] = np.where(present, error, np.nan)
        observe[:, :3, :6] = _linkage_rows(path)
        observe[:, range(3), range(6, 9)] = 1.0
    observe[:, linkage:, : 3 * trucks] = np.eye(3 * trucks)
    if signals.poses is not None:
        for number in range(trucks):
            pose = slice(linkage + 3 * number, linkage + 3 * number + 3)
            measured[:, pose], stated[:, pose] = _pose_rows(signals, ends, number)
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


def _pose_rows(signals: Signals, ends: NDArray[np.int64], number: int) -> tuple[Array, Array]:
    """Return measured minus expected poses of a truck at each end, and their variances, `(M + 1, 3)` each.

    Of several poses that are nearest to one end the means are taken.
    """
    assert signals.poses is not None
    truck = signals.trucks[number]
    poses = signals.poses.of(truck)
    time, end = _stamps(signals, ends, truck)
    error = poses.pose - poses_at(time, signals.time, signals.path[:, number])
    error[:, 2] = wrap(error[:, 2])
    stated = stated_sigma(poses.sigma) ** 2
    known = np.isfinite(error)
    total, count, variance = np.zeros((3, len(ends), 3))
    np.add.at(total, end, np.where(known, error, 0.0))
    np.add.at(count, end, known)
    np.add.at(variance, end, np.where(known, stated, 0.0))
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(count > 0, total / count, np.nan), np.where(count > 0, variance / count**2, 1.0)


def stated_sigma(sigma: Array) -> Array:
    """Return standard deviations of poses `(P, 3)` [m, m, rad], the usual ones where none are stated."""
    return np.where(np.isfinite(sigma) & (sigma > 0.0), sigma, DEFAULT_POSE_SIGMA)


def _stamps(signals: Signals, ends: NDArray[np.int64], truck: TruckName) -> tuple[Array, NDArray[np.int64]]:
    """Return the times (P,) of a truck's poses [s], and the number of the window's end nearest to each."""
    if signals.poses is None:
        return np.zeros(0), np.zeros(0, np.int64)
    moments = signals.time[ends]
    time = signals.poses.of(truck).time
    return time, np.searchsorted(0.5 * (moments[1:] + moments[:-1]), time)
