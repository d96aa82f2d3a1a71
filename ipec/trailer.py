"""The encoder trailer: one robot that tows an unpowered axle on one rotary joint, C 7.

The trailer's axle cannot slip sideways, so its heading follows from the hitch's motion alone; together
with the joint's change it shows how far the robot has really turned.
"""

import math
from dataclasses import dataclass

import numpy as np

from omnimate.vehicle.compiled import Array, compiled


@dataclass(frozen=True, slots=True)
class Trailer:
    """The sizes of the robot and its trailer.

    Attributes:
        wheelbase: Wheelbase of the robot [m].
        hitch: Distance of the joint behind the robot's axle [m].
        length: Length of the trailer from the joint to its axle [m].
    """

    wheelbase: float
    hitch: float
    length: float


@dataclass(frozen=True, slots=True)
class TrailerState:
    """The pose of the robot after a sample.

    Attributes:
        pose: Pose of the robot [m, m, rad], shape `(3,)`.
        joint: Joint angle gamma, heading of the robot minus heading of the trailer [rad]; nan before the
            first sample.
        correction: Correction of the heading in the last sample [rad].
    """

    pose: Array
    joint: float = math.nan
    correction: float = 0.0


@compiled
def _turn(way: float, joint: float, change: float, hitch: float, length: float) -> float:
    """Return the robot's turn in a sample [rad]: (d_gamma + (way/l) sin gamma) / (1 + (d/l) cos gamma)."""
    return (change + way / length * math.sin(joint)) / (1.0 + hitch / length * math.cos(joint))


@compiled
def _advance(
    pose: Array, before: float, left: float, right: float, joint: float, sizes: tuple[float, float, float]
) -> float:
    """Move a pose `(3,)` in place by one sample; return the correction of its heading [rad]."""
    wheelbase, hitch, length = sizes
    way, rolled = 0.5 * (left + right), (right - left) / wheelbase
    turn = rolled
    if not math.isnan(before) and not math.isnan(joint):
        turn = _turn(way, 0.5 * (before + joint), joint - before, hitch, length)
    pose[0] += way * math.cos(pose[2] + 0.5 * turn)
    pose[1] += way * math.sin(pose[2] + 0.5 * turn)
    pose[2] += turn
    return turn - rolled


@compiled
def _track(
    pose: Array, before: float, travel: Array, joint: Array, sizes: tuple[float, float, float], path: Array
) -> None:
    for sample in range(len(joint)):
        path[sample, 3] = _advance(pose, before, travel[sample, 0], travel[sample, 1], joint[sample], sizes)
        path[sample, :3] = pose
        before = joint[sample]


def step(trailer: Trailer, state: TrailerState, left: float, right: float, joint: float) -> TrailerState:
    """Return the state after one sample.

    Args:
        trailer: Sizes of the robot and its trailer.
        state: State before the sample.
        left: Travel of the robot's left wheel [m].
        right: Travel of the robot's right wheel [m].
        joint: Joint angle gamma [rad], continuous; nan where it was not read.
    """
    pose = state.pose.copy()
    sizes = trailer.wheelbase, trailer.hitch, trailer.length
    correction = _advance(pose, state.joint, left, right, joint, sizes)
    return TrailerState(pose, joint, correction)


def track(trailer: Trailer, state: TrailerState, travel: Array, joint: Array) -> tuple[Array, Array]:
    """Return the poses `(N, 3)` and the heading corrections `(N,)` [rad] after each sample.

    Args:
        trailer: Sizes of the robot and its trailer.
        state: State before the first sample.
        travel: Travel of the left and the right wheel in each sample [m], shape `(N, 2)`.
        joint: Joint angle gamma in each sample [rad], continuous; nan where it was not read, shape `(N,)`.
    """
    path = np.empty((len(joint), 4))
    sizes = trailer.wheelbase, trailer.hitch, trailer.length
    _track(state.pose.copy(), state.joint, travel, joint, sizes, path)
    return path[:, :3], path[:, 3]
