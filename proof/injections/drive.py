"""A drive of a single truck as injections see it: ways of its wheels, and poses measured from outside."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Self

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

SMOOTHING = 0.2  # [s] over which speeds are taken; a count of 0.1 mm is then 0.5 mm/s
SIDES = ("a.left", "a.right")


@dataclass(frozen=True, slots=True)
class Drive:
    """One recording of a truck.

    Attributes:
        time: Time of each sample [s], shape `(N,)`.
        way: Way of the left and the right wheel by their counters, from the counters' zeros [m], `(N, 2)`.
        count: Way of one count of each wheel [m], shape `(2,)`.
        radius: Radius of each wheel [m], shape `(2,)`.
        wheelbase: Distance between the wheels [m].
        pose_time: Time of each measured pose [s], shape `(M,)`.
        pose: Measured x [m], y [m] and heading [rad], the heading unwrapped, shape `(M, 3)`.
    """

    time: Array
    way: Array
    count: Array
    radius: Array
    wheelbase: float
    pose_time: Array
    pose: Array

    def with_way(self, wheel: int, way: Array) -> Self:
        """Return the drive with another way `(N,)` of one wheel [m]."""
        changed = self.way.copy()
        changed[:, wheel] = way
        return replace(self, way=changed)

    def with_pose_time(self, pose_time: Array) -> Self:
        """Return the drive with other stamps `(M,)` of its poses [s]."""
        return replace(self, pose_time=pose_time)

    @property
    def path(self) -> Array:
        """Dead reckoning from the origin on exact arcs [m, m, rad], shape `(N, 3)`."""
        left, right = np.diff(self.way, axis=0).T
        yaw, forward = (right - left) / self.wheelbase, 0.5 * (left + right)
        heading = np.concatenate(([0.0], np.cumsum(yaw)))
        middle, chord = heading[:-1] + 0.5 * yaw, forward * np.sinc(yaw / (2.0 * np.pi))
        steps = np.stack([chord * np.cos(middle), chord * np.sin(middle)], axis=1)
        return np.column_stack([np.concatenate((np.zeros((1, 2)), np.cumsum(steps, axis=0))), heading])


def rates(way: Array, time: Array) -> tuple[Array, Array]:
    """Return speed [m/s] and acceleration [m/s^2] in each step, shape `(N - 1,)`, of a way `(N,)` [m]."""
    period = float(np.median(np.diff(time)))
    half, index = max(1, round(0.5 * SMOOTHING / period)), np.arange(len(time))
    before, after = np.maximum(index - half, 0), np.minimum(index + half, len(time) - 1)
    span = time[after] - time[before]
    speed = (way[after] - way[before]) / span
    acceleration = (speed[after] - speed[before]) / span
    return 0.5 * (speed[1:] + speed[:-1]), 0.5 * (acceleration[1:] + acceleration[:-1])


def increments(path: Array) -> Array:
    """Return the motion from each pose of a path `(K, 3)` to the next, in its frame, `(K - 1, 3)`."""
    cosine, sine = np.cos(path[:-1, 2]), np.sin(path[:-1, 2])
    x, y, yaw = np.diff(path, axis=0).T
    return np.stack([cosine * x + sine * y, cosine * y - sine * x, yaw], axis=1)
