"""Two robots that no linkage connects, but that measure each other's range and bearings, C 7.

A bearing is the direction to the other robot, measured counter-clockwise from the measuring robot's heading.
Range and bearings contain what a linkage measures, so the correction is the CLAPPER's.
"""

import math
from dataclasses import dataclass

import numpy as np

from omnimate.vehicle.compiled import Array, compiled
from omnimate.vehicle.compiled_se2 import direction, follow, roll, wrap


@compiled
def correct_unconnected(poses: Array, distance: float, bearing_a: float, bearing_b: float) -> None:
    """Correct the poses `(2, 3)` of robots a and b, both advanced by their own wheels before, in place.

    The line from b to a has the heading lambda; theta_A' = lambda + pi - phi_A, theta_B' = lambda - phi_B,
    B' = A - rho u(lambda).

    Args:
        poses: Poses of a and b [m, m, rad], shape `(2, 3)`; changed in place.
        distance: Range rho between the robots' centres [m].
        bearing_a: Bearing phi_A of b measured by a [rad].
        bearing_b: Bearing phi_B of a measured by b [rad].
    """
    heading = direction(poses[0], poses[1])
    poses[0, 2] += wrap(heading + math.pi - bearing_a - poses[0, 2])
    poses[1, 2] += wrap(heading - bearing_b - poses[1, 2])
    follow(poses[1], poses[0], distance, heading)


@compiled
def advance_pair(poses: Array, travel: Array, sight: Array, wheelbase: Array) -> None:
    """Take one sample, in place: travel `(4,)` [m], sight `(3,)` range and bearings, wheelbases `(2,)`."""
    roll(poses[0], travel[0], travel[1], wheelbase[0])
    roll(poses[1], travel[2], travel[3], wheelbase[1])
    if not (math.isnan(sight[0]) or math.isnan(sight[1]) or math.isnan(sight[2])):
        correct_unconnected(poses, sight[0], sight[1], sight[2])


@compiled
def _track(poses: Array, travel: Array, sight: Array, wheelbase: Array, path: Array) -> None:
    for sample in range(len(travel)):
        advance_pair(poses, travel[sample], sight[sample], wheelbase)
        path[sample] = poses


@dataclass(frozen=True, slots=True)
class PairState:
    """The poses of both robots after a sample.

    Attributes:
        poses: Poses of a and b [m, m, rad], shape `(2, 3)`.
    """

    poses: Array


def step(state: PairState, travel: Array, sight: Array, wheelbase: Array) -> PairState:
    """Return the state after one sample.

    Args:
        state: State before the sample.
        travel: Travel of a's left and right wheel, then of b's [m], shape `(4,)`.
        sight: Range [m], bearing of b measured by a, bearing of a measured by b [rad], shape `(3,)`; nan
            where nothing was measured.
        wheelbase: Wheelbase of a and b [m], shape `(2,)`.
    """
    poses = state.poses.copy()
    advance_pair(poses, travel, sight, wheelbase)
    return PairState(poses)


def track(state: PairState, travel: Array, sight: Array, wheelbase: Array) -> Array:
    """Return the poses `(N, 2, 3)` after each sample; travel `(N, 4)`, sight `(N, 3)` as in `step`."""
    path = np.empty((len(travel), 2, 3))
    _track(state.poses.copy(), travel, sight, wheelbase, path)
    return path
