"""Segments: what the ways between two absolute poses say of robot and floor, as small linear problems.

For each way of a truck from one pose to the next: how far its odometry ends from the measured pose, and how
this depends, to first order, on the robot's parameters, on the floor's roughness, and on way that wheels lose
anywhere. The drive is linearised along the likeliest path between both poses, not along odometry's, which may
end half a metre beside it: the floor's random walk (Chong & Kleeman, 1997) is conditioned on both ends.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from omnimate.vehicle.arcs import roll, travel_lever
from omnimate.vehicle.compiled import Array, compiled
from omnimate.vehicle.floor import CONCRETE_ROUGHNESS, floor_covariance
from omnimate.vehicle.odometry import truck_travel, wheels_of
from omnimate.vehicle.se2 import lever_matrix, wrap

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from omnimate.vehicle.parameters import TruckName
    from omnimate.vehicle.recording import Poses, Recording

PARAMETERS = ("left wheel", "right wheel", "wheelbase")  # ratios of true to believed size, less 1 [1]
SHORTEST = 2.0  # [m] of travel, below which a way joins the next one
STEP = 0.05  # [m] of travel between the points of a path
_ROUNDS = 2  # of linearisation; a third one changes no residual by 0.1 mm on an ordinary floor
# Where poses.csv states no standard deviation: of a good docking station [m, m, rad].
_UNSTATED = np.array([0.003, 0.003, 0.003])


@dataclass(frozen=True, slots=True)
class Segments:
    """The ways of one truck in one recording.

    Attributes:
        time: Time at the end of each way [s], `(S,)`.
        residual: Measured pose at the end less odometry's from the pose at the start, in the world's frame
            [m, m, rad], `(S, 3)`.
        jacobian: Its derivative by `PARAMETERS`, `(S, 3, 3)`.
        rough: Its covariance for a roughness of 1 m/sqrt(m), `(S, 3, 3)`.
        lever: End less start of the path [m], `(S, 2)`, by which an error of the first heading acts.
        sigma: Standard deviations of the first and of the last pose [m, m, rad], `(S, 2, 3)`.
        follows: Whether the first pose of a way is the last one of the way before, `(S,)`.
    """

    time: Array
    residual: Array
    jacobian: Array
    rough: Array
    lever: Array
    sigma: Array
    follows: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.time)

    def covariance(self, roughness: float) -> Array:
        """Return the covariance of all residuals `(3 S, 3 S)` on a floor of a roughness [m/sqrt(m)].

        Ways that follow each other share the error of the pose between them.
        """
        count = len(self)
        transport = lever_matrix(self.lever)
        first, last = (self.sigma[:, end, :, np.newaxis] ** 2 * np.eye(3) for end in (0, 1))
        blocks = np.zeros((count, 3, count, 3))
        at = np.arange(count)
        blocks[at, :, at, :] = (
            roughness**2 * self.rough + transport @ first @ transport.transpose(0, 2, 1) + last
        )
        after = np.flatnonzero(self.follows)
        shared = -last[after - 1] @ transport[after].transpose(0, 2, 1)
        blocks[after - 1, :, after, :] = shared
        blocks[after, :, after - 1, :] = shared.transpose(0, 2, 1)
        return blocks.reshape(3 * count, 3 * count)


@dataclass(frozen=True, slots=True)
class Steps:
    """The steps of the paths of all ways.

    Attributes:
        way: Number of the way, `(N,)`.
        left: Position of the left wheel in the middle of the step [m], `(N, 2)`.
        right: Likewise of the right wheel.
        travel: Travel of the left and the right wheel [m], `(N, 2)`.
        gain: Derivative of the residual by travel of the left and the right wheel, `(N, 3, 2)`.
    """

    way: NDArray[np.int64]
    left: Array
    right: Array
    travel: Array
    gain: Array


def segments_of(recording: Recording, truck: TruckName = "a") -> tuple[Segments, Steps] | None:
    """Return the ways of a truck between absolute poses, and their steps; None where there are not two poses.

    Args:
        recording: A recording with poses, dense or at docks; only poses with a heading are used.
        truck: Name of the truck.
    """
    fixes = _fixes(recording, truck)
    if fixes is None:
        return None
    left, right, _ = truck_travel(recording, truck)
    travelled = np.concatenate(([0.0], np.cumsum(0.5 * np.abs(np.diff(left)) + 0.5 * np.abs(np.diff(right)))))
    chosen = _far_apart(np.interp(fixes.time, recording.time, travelled))
    cuts = [gap.end for gap in recording.gaps if gap.channel in wheels_of(truck) and gap.reason != "missing"]
    base = recording.vehicle.trucks[truck].wheelbase
    sigma = np.where(np.isfinite(fixes.sigma) & (fixes.sigma > 0.0), fixes.sigma, _UNSTATED)
    ways, ends = [], []
    for start, end in pairwise(chosen):
        if any(fixes.time[start] < cut <= fixes.time[end] for cut in cuts):
            continue
        at = _moments(recording.time, travelled, fixes.time[start], fixes.time[end])
        rolled = np.column_stack([np.diff(np.interp(at, recording.time, wheel)) for wheel in (left, right)])
        ways.append(_way(rolled, base, fixes.pose[[start, end]], sigma[[start, end]]))
        ends.append((start, end))
    if not ways:
        return None
    numbers = np.repeat(np.arange(len(ways)), [len(way.travel) for way in ways])
    starts, lasts = np.array(ends).T
    segments = Segments(
        fixes.time[lasts],
        np.array([way.residual for way in ways]),
        np.array([way.jacobian for way in ways]),
        np.array([way.rough for way in ways]),
        np.array([way.lever for way in ways]),
        np.stack([sigma[starts], sigma[lasts]], axis=1),
        np.concatenate(([False], starts[1:] == lasts[:-1])),
    )
    steps = Steps(
        numbers,
        np.concatenate([way.left for way in ways]),
        np.concatenate([way.right for way in ways]),
        np.concatenate([way.travel for way in ways]),
        np.concatenate([way.gain for way in ways]),
    )
    return segments, steps


def _fixes(recording: Recording, truck: TruckName) -> Poses | None:
    """Return the whole poses of a truck within the recording's time; None where there are not two."""
    if recording.poses is None:
        return None
    poses = recording.poses.of(truck)
    inside = (poses.time >= recording.time[0]) & (poses.time <= recording.time[-1])
    kept = inside & np.isfinite(poses.pose).all(axis=1)
    if kept.sum() < 2:
        return None
    return type(poses)(poses.time[kept], poses.body[kept], poses.pose[kept], poses.sigma[kept])


def _far_apart(travelled: Array) -> list[int]:
    """Return the numbers of poses that lie at least `SHORTEST` of travel apart."""
    chosen = [0]
    for number, way in enumerate(travelled.tolist()):
        if way - travelled[chosen[-1]] >= SHORTEST:
            chosen.append(number)
    return chosen


def _moments(time: Array, travelled: Array, start: float, end: float) -> Array:
    """Return times [s] from start to end with `STEP` of travel between them."""
    inside = (time > start) & (time < end)
    _, first = np.unique(np.floor(travelled[inside] / STEP), return_index=True)
    return np.concatenate(([start], time[inside][first], [end]))


@dataclass(frozen=True, slots=True)
class _Way:
    """One way; the fields are rows of `Segments` and `Steps`."""

    residual: Array
    jacobian: Array
    rough: Array
    lever: Array
    left: Array
    right: Array
    travel: Array
    gain: Array


def _way(rolled: Array, base: float, poses: Array, sigma: Array) -> _Way:
    """Return one way from the travel of its wheels `(N, 2)` [m] between two measured poses `(2, 3)`."""
    variance = CONCRETE_ROUGHNESS**2 * np.abs(rolled)
    lost = np.zeros_like(rolled)  # what the floor did to each wheel in each step, to the best of knowledge
    path, gain = np.empty((len(rolled) + 1, 3)), np.empty((len(rolled), 3, 2))
    for _ in range(_ROUNDS):
        _linearise(rolled, lost, base, poses[0], path, gain)
        rough = floor_covariance(gain, rolled).sum(axis=0)
        lever = path[-1, :2] - path[0, :2]
        transport = lever_matrix(lever)
        covariance = (
            CONCRETE_ROUGHNESS**2 * rough + (transport * sigma[0] ** 2) @ transport.T + np.diag(sigma[1] ** 2)
        )
        ended = poses[1] - path[-1]
        ended[2] = float(wrap(ended[2]))
        residual = ended + np.einsum("nij,nj->i", gain, lost)
        lost = variance * np.einsum("nij,i->nj", gain, np.linalg.solve(covariance, residual))
    turn = (rolled[:, 1] - rolled[:, 0]) / base
    by_turn = 0.5 * base * (gain[:, :, 1] - gain[:, :, 0])
    jacobian = np.column_stack(
        [gain[:, :, 0].T @ rolled[:, 0], gain[:, :, 1].T @ rolled[:, 1], -by_turn.T @ turn]
    )
    middle = 0.5 * (path[:-1] + path[1:])
    beside = 0.5 * base * np.column_stack([-np.sin(middle[:, 2]), np.cos(middle[:, 2])])
    return _Way(
        residual, jacobian, rough, lever, middle[:, :2] + beside, middle[:, :2] - beside, rolled, gain
    )


@compiled
def _linearise(rolled: Array, lost: Array, base: float, start: Array, path: Array, gain: Array) -> None:
    """Fill the likeliest path of a way, and how its end depends on what the wheels roll.

    Args:
        rolled: Travel of the wheels in each step [m], `(N, 2)`.
        lost: What the floor did to it [m], `(N, 2)`.
        base: Wheelbase [m].
        start: First pose, `(3,)`.
        path: Filled with the poses between the steps, `(N + 1, 3)`.
        gain: Filled with the derivative of the end by the travel of both wheels, `(N, 3, 2)`.
    """
    path[0] = start
    for step in range(len(rolled)):
        path[step + 1] = path[step]
        roll(path[step + 1], rolled[step, 0] + lost[step, 0], rolled[step, 1] + lost[step, 1], base)
    for step in range(len(rolled)):
        x = path[-1, 0] - 0.5 * (path[step, 0] + path[step + 1, 0])
        y = path[-1, 1] - 0.5 * (path[step, 1] + path[step + 1, 1])
        heading = 0.5 * (path[step, 2] + path[step + 1, 2])
        for wheel in range(2):
            turn = (2.0 * wheel - 1.0) / base
            gain[step, 0, wheel], gain[step, 1, wheel] = travel_lever(heading, x, y, turn)
            gain[step, 2, wheel] = turn
