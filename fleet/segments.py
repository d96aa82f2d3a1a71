"""Segments of a recording between absolute poses, as small linear problems, and the cells that they cross.

A segment is the drive of a truck from one pose to the next. Its residual is the measured pose at the end less
that of odometry; it depends, to first order, on the robot's parameters, on the floor's roughness, and on
travel that wheels lose in cells of the floor. The segment is linearised along the most probable path between
both poses, not along odometry's, which may end half a metre from it: the random walk of the floor (Chong &
Kleeman, 1997) is conditioned on both ends.
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

    from omnimate.vehicle.recording import Poses, Recording

PARAMETERS = ("left wheel", "right wheel", "wheelbase")  # ratios of true to nominal size, less 1 [1]
JOINT_NUMBERS = ("joint_a", "joint_b")  # biases of the joints' encoders [rad]
CELL = 0.25  # [m] side of a cell of the floor; cells lie on whole multiples of it
MIN_SEGMENT = 2.0  # [m] of travel; a shorter segment is joined with the next one
STEP_LENGTH = 0.05  # [m] of travel between the points of a path
_LINEARISATIONS = 2  # a third one changes no residual by 0.1 mm on a floor of usual roughness
# [m, m, rad] where poses.csv has no standard deviation: that of a good docking station (assumption).
_DEFAULT_POSE_SIGMA = np.array([0.003, 0.003, 0.003])


@dataclass(frozen=True, slots=True)
class Segments:
    """The segments of one truck in one recording."""

    time: Array  # time at the end of each segment [s], `(S,)`
    # measured pose at the end less odometry's from the pose at the start, in the world's frame [m, m, rad],
    # `(S, 3)`
    residual: Array
    jacobian: Array  # its derivative by `PARAMETERS` [m, m, rad], `(S, 3, 3)`
    unit_covariance: Array  # its covariance for a roughness of 1 m/sqrt(m), `(S, 3, 3)`
    # end less start of the path [m], `(S, 2)`: an error of the first heading times this, turned by 90
    # degrees, is the error of the end
    lever: Array
    sigma: Array  # standard deviations of the first and of the last pose [m, m, rad], `(S, 2, 3)`
    # whether the first pose of a segment is the last one of the segment before, `(S,)`
    follows: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.time)

    def covariance(self, roughness: float) -> Array:
        """Return the covariance of all residuals `(3 S, 3 S)` on a floor of a roughness [m/sqrt(m)].

        Consecutive segments share the error of the pose between them.
        """
        count = len(self)
        transport = lever_matrix(self.lever)
        first, last = (self.sigma[:, end, :, np.newaxis] ** 2 * np.eye(3) for end in (0, 1))
        blocks = np.zeros((count, 3, count, 3))
        diagonal = np.arange(count)
        blocks[diagonal, :, diagonal, :] = (
            roughness**2 * self.unit_covariance + transport @ first @ transport.transpose(0, 2, 1) + last
        )
        after = np.flatnonzero(self.follows)
        shared = -last[after - 1] @ transport[after].transpose(0, 2, 1)
        blocks[after - 1, :, after, :] = shared
        blocks[after, :, after - 1, :] = shared.transpose(0, 2, 1)
        return blocks.reshape(3 * count, 3 * count)


@dataclass(frozen=True, slots=True)
class Crossings:
    """One row for each segment and each cell that one of its wheels, or the truck's middle, goes over."""

    segment: NDArray[np.int32]  # number of the segment, `(K,)`
    cell: NDArray[np.int32]  # number of the cell along x and along y, `(K, 2)`
    # derivative of the residual by the fraction of their travel that wheels lose in the cell [m, m, rad],
    # `(K, 3)`
    loss: Array
    # travel of the truck's middle over the cell [m], `(K,)`: derivative of the residual's x by creep along x
    # per metre, and of its y by creep along y
    creep: Array

    def rows(self, rows: NDArray[np.int64]) -> Crossings:
        """Return the rows with these numbers."""
        return Crossings(self.segment[rows], self.cell[rows], self.loss[rows], self.creep[rows])


def cut_segments(recording: Recording) -> tuple[Segments, Crossings] | None:
    """Return the segments of truck a between absolute poses, and their crossings; None without two poses.

    The poses may be dense or at docks; only those with a heading are used.
    """
    fixes = _poses_with_heading(recording)
    if fixes is None:
        return None
    left, right, _ = truck_travel(recording, "a")
    travelled = np.concatenate(([0.0], np.cumsum(0.5 * np.abs(np.diff(left)) + 0.5 * np.abs(np.diff(right)))))
    chosen = _choose_ends(np.interp(fixes.time, recording.time, travelled))
    cuts = [gap.end for gap in recording.gaps if gap.channel in wheels_of("a") and gap.reason != "missing"]
    base = recording.vehicle.trucks["a"].wheelbase
    sigma = np.where(np.isfinite(fixes.sigma) & (fixes.sigma > 0.0), fixes.sigma, _DEFAULT_POSE_SIGMA)
    rows, crossed = [], []
    ends: list[tuple[int, int]] = []
    for start, end in pairwise(chosen):
        if any(fixes.time[start] < cut <= fixes.time[end] for cut in cuts):
            continue
        times = _choose_times(recording.time, travelled, fixes.time[start], fixes.time[end])
        travel = np.column_stack(
            [np.diff(np.interp(times, recording.time, wheel)) for wheel in (left, right)]
        )
        row, path, gain = _linearise_segment(travel, base, fixes.pose[[start, end]], sigma[[start, end]])
        rows.append(row)
        crossed.append(_cross_cells(len(ends), travel, base, path, gain))
        ends.append((start, end))
    if not ends:
        return None
    residual, jacobian, unit_covariance, lever = (np.array(column) for column in zip(*rows, strict=True))
    starts, lasts = np.array(ends).T
    segments = Segments(
        fixes.time[lasts],
        residual,
        jacobian,
        unit_covariance,
        lever,
        np.stack([sigma[starts], sigma[lasts]], axis=1),
        np.concatenate(([False], starts[1:] == lasts[:-1])),
    )
    number, cell, loss, creep = (np.concatenate(column) for column in zip(*crossed, strict=True))
    return segments, Crossings(number, cell, loss, creep)


def _poses_with_heading(recording: Recording) -> Poses | None:
    """Return the poses of truck a with a heading, within the recording's time; None if fewer than two."""
    if recording.poses is None:
        return None
    poses = recording.poses.of("a")
    inside = (poses.time >= recording.time[0]) & (poses.time <= recording.time[-1])
    usable = inside & np.isfinite(poses.pose).all(axis=1)
    return poses.select(usable) if usable.sum() >= 2 else None


def _choose_ends(travelled: Array) -> list[int]:
    """Return the numbers of poses with at least `MIN_SEGMENT` of travel between each and the next."""
    chosen = [0]
    for number, distance in enumerate(travelled.tolist()):
        if distance - travelled[chosen[-1]] >= MIN_SEGMENT:
            chosen.append(number)
    return chosen


def _choose_times(time: Array, travelled: Array, start: float, end: float) -> Array:
    """Return times [s] from start to end with `STEP_LENGTH` of travel between them."""
    inside = (time > start) & (time < end)
    _, first = np.unique(np.floor(travelled[inside] / STEP_LENGTH), return_index=True)
    return np.concatenate(([start], time[inside][first], [end]))


def _linearise_segment(
    travel: Array, base: float, poses: Array, sigma: Array
) -> tuple[tuple[Array, Array, Array, Array], Array, Array]:
    """Return a row of `Segments` (residual to lever), the path `(N + 1, 3)`, and the gain `(N, 3, 2)`.

    The gain is the derivative of the end by the travel of both wheels in each step.

    Both wheels travel `(N, 2)` [m] in N steps; the measured poses at both ends, and their standard
    deviations, are `(2, 3)`.
    """
    variance = CONCRETE_ROUGHNESS**2 * np.abs(travel)
    slip = np.zeros_like(travel)  # most probable travel that the floor adds in each step [m]
    path, gain = np.empty((len(travel) + 1, 3)), np.empty((len(travel), 3, 2))
    for _ in range(_LINEARISATIONS):
        _linearise(travel, slip, base, poses[0], path, gain)
        unit_covariance = floor_covariance(gain, travel).sum(axis=0)
        lever = path[-1, :2] - path[0, :2]
        transport = lever_matrix(lever)
        covariance = (
            CONCRETE_ROUGHNESS**2 * unit_covariance
            + (transport * sigma[0] ** 2) @ transport.T
            + np.diag(sigma[1] ** 2)
        )
        end_error = poses[1] - path[-1]
        end_error[2] = float(wrap(end_error[2]))
        residual = end_error + np.einsum("nij,nj->i", gain, slip)
        slip = variance * np.einsum("nij,i->nj", gain, np.linalg.solve(covariance, residual))
    turn = (travel[:, 1] - travel[:, 0]) / base
    turn_gain = 0.5 * base * (gain[:, :, 1] - gain[:, :, 0])
    jacobian = np.column_stack(
        [gain[:, :, 0].T @ travel[:, 0], gain[:, :, 1].T @ travel[:, 1], -turn_gain.T @ turn]
    )
    return (residual, jacobian, unit_covariance, lever), path, gain


def _cross_cells(
    number: int, travel: Array, base: float, path: Array, gain: Array
) -> tuple[NDArray[np.int32], NDArray[np.int32], Array, Array]:
    """Return the rows of `Crossings` of one segment, summed over the steps in each cell."""
    middle = 0.5 * (path[:-1] + path[1:])
    to_left = 0.5 * base * np.column_stack([-np.sin(middle[:, 2]), np.cos(middle[:, 2])])
    places = np.concatenate([middle[:, :2] + to_left, middle[:, :2] - to_left, middle[:, :2]])
    values = np.zeros((3, len(travel), 4))  # for left wheel, right wheel, middle: loss (3), creep
    values[:2, :, :3] = -gain.transpose(2, 0, 1) * travel.T[:, :, np.newaxis]
    values[2, :, 3] = np.abs(travel.mean(axis=1))
    cells, owner = np.unique(np.round(places / CELL).astype(np.int32), axis=0, return_inverse=True)
    sums = np.zeros((len(cells), 4))
    np.add.at(sums, owner.ravel(), values.reshape(-1, 4))
    return np.full(len(cells), number, np.int32), cells, sums[:, :3], sums[:, 3]


@compiled
def _linearise(travel: Array, slip: Array, base: float, start: Array, path: Array, gain: Array) -> None:
    """Fill the path of a segment, and the derivative of its end by the wheels' travel.

    Travel from the encoders, and slip that the floor adds, are `(N, 2)` [m]. The path, `(N + 1, 3)`, is
    filled with the poses between the steps, from the first one on; the gain, `(N, 3, 2)`, with the derivative
    of the end by the travel of both wheels.
    """
    path[0] = start
    for step in range(len(travel)):
        path[step + 1] = path[step]
        roll(path[step + 1], travel[step, 0] + slip[step, 0], travel[step, 1] + slip[step, 1], base)
    for step in range(len(travel)):
        x = path[-1, 0] - 0.5 * (path[step, 0] + path[step + 1, 0])
        y = path[-1, 1] - 0.5 * (path[step, 1] + path[step + 1, 1])
        heading = 0.5 * (path[step, 2] + path[step + 1, 2])
        for wheel in range(2):
            turn = (2.0 * wheel - 1.0) / base
            gain[step, 0, wheel], gain[step, 1, wheel] = travel_lever(heading, x, y, turn)
            gain[step, 2, wheel] = turn
