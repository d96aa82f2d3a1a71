"""Two robots that no linkage connects, but that measure each other's range and bearings, C 7.

A bearing is the direction to the other robot in the own frame, counter-clockwise from ahead. Range and
bearings say what a linkage says, so the correction is the CLAPPER's.
"""

import math
from dataclasses import dataclass

import numpy as np

from ipec.geometry import direction, follow, roll, wrap
from vehicle.compiled import Array, compiled


@compiled
def correct_unconnected(poses: Array, distance: float, bearing_a: float, bearing_b: float) -> None:
    """Correct the poses `(2, 3)` of robots a and b, both advanced by their own wheels before, in place.

    The line from b to a has the heading lambda; theta_A' = lambda + pi - phi_A, theta_B' = lambda - phi_B,
    B' = A - rho u(lambda).

    Args:
        poses: of a and b.
        distance: range rho between the robots' centres [m].
        bearing_a: phi_A, at which a sees b [rad].
        bearing_b: phi_B, at which b sees a [rad].
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
    """Poses `(2, 3)` of robots a and b."""

    poses: Array


def step(state: PairState, travel: Array, sight: Array, wheelbase: Array) -> PairState:
    """Return the state after one sample.

    Args:
        state: before it.
        travel: `(4,)` of a's left and right wheel, then b's [m].
        sight: `(3,)` range [m], bearing of b seen from a, of a seen from b [rad]; nan where not seen.
        wheelbase: `(2,)` [m].
    """
    poses = state.poses.copy()
    advance_pair(poses, travel, sight, wheelbase)
    return PairState(poses)


def track(state: PairState, travel: Array, sight: Array, wheelbase: Array) -> Array:
    """Return the poses `(N, 2, 3)` after each sample; travel `(N, 4)` and sight `(N, 3)` as in `step`."""
    path = np.empty((len(travel), 2, 3))
    _track(state.poses.copy(), travel, sight, wheelbase, path)
    return path
