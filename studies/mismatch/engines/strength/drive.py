"""A drive as an effect's strength is judged: ways of wheels, readings of the linkage, measured poses."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Self

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

SMOOTHING = 0.2  # [s] over which speeds are taken; a count of 0.1 mm is then 0.5 mm/s
WHEELS = ("a.left", "a.right", "b.left", "b.right")
LINKAGE = ("joint_a", "joint_b", "link")
TRUCKS = ("a", "b")


@dataclass(frozen=True, slots=True)
class Poses:
    """Measured poses of one truck.

    Attributes:
        time: Stamp of each pose [s], shape `(M,)`.
        pose: Measured x [m], y [m] and heading [rad], the heading unwrapped, shape `(M, 3)`.
    """

    time: Array
    pose: Array


@dataclass(frozen=True, slots=True)
class Drive:
    """One recording of a robot with T trucks and W = 2 T wheels.

    Attributes:
        time: Time of each sample [s], shape `(N,)`.
        way: Way of each wheel by its counter, from the counter's zero [m], shape `(N, W)`.
        count: Way of one count of each wheel [m], shape `(W,)`.
        radius: Radius of each wheel [m], shape `(W,)`.
        wheelbase: Distance between the wheels of each truck [m], shape `(T,)`.
        reading: Readings of joint_a [rad], joint_b [rad] and the link's length [m], shape `(N, 3)`; no
            columns with a single truck.
        rest: Length at which the link reads its zero [m].
        poses: Measured poses of each truck, by its number; trucks without any are absent.
        more: Motion of each truck that its wheels do not make, in its own frame: forward [m], left [m], yaw
            [rad] in each step, shape `(N - 1, T, 3)`; or None for none.
    """

    time: Array
    way: Array
    count: Array
    radius: Array
    wheelbase: Array
    reading: Array
    rest: float
    poses: dict[int, Poses]
    more: Array | None = None

    @property
    def trucks(self) -> int:
        """Number of trucks."""
        return len(self.wheelbase)

    def with_way(self, wheel: int, way: Array) -> Self:
        """Return the drive with another way `(N,)` of one wheel [m]."""
        changed = self.way.copy()
        changed[:, wheel] = way
        return replace(self, way=changed)

    def with_reading(self, channel: int, reading: Array) -> Self:
        """Return the drive with another reading `(N,)` of the linkage [rad, m]."""
        changed = self.reading.copy()
        changed[:, channel] = reading
        return replace(self, reading=changed)

    def with_more(self, truck: int, more: Array) -> Self:
        """Return the drive with motion `(N - 1, 3)` added to that of one truck [m, m, rad]."""
        changed = np.zeros((len(self.time) - 1, self.trucks, 3)) if self.more is None else self.more.copy()
        changed[:, truck] += more
        return replace(self, more=changed)

    def twist(self, truck: int) -> Array:
        """Return a truck's motion in each step, `(N - 1, 3)`: forward [m], left [m], yaw [rad]."""
        left, right = np.diff(self.way[:, 2 * truck : 2 * truck + 2], axis=0).T
        yaw = (right - left) / self.wheelbase[truck]
        twist = np.stack([0.5 * (left + right), np.zeros_like(yaw), yaw], axis=1)
        return twist if self.more is None else np.asarray(twist + self.more[:, truck])

    def path(self, truck: int) -> Array:
        """Return a truck's dead reckoning from the origin [m, m, rad], shape `(N, 3)`."""
        twist = self.twist(truck)
        chord = twist[:, :2] * np.sinc(twist[:, 2] / (2.0 * np.pi))[:, None]
        heading = np.concatenate(([0.0], np.cumsum(twist[:, 2])))
        steps = turned(heading[:-1] + 0.5 * twist[:, 2], chord)
        return np.column_stack([np.concatenate((np.zeros((1, 2)), np.cumsum(steps, axis=0))), heading])


def turned(angle: Array, vector: Array) -> Array:
    """Return vectors `(K, 2)` turned by angles `(K,)` [rad]."""
    cosine, sine, (x, y) = np.cos(angle), np.sin(angle), vector.T
    return np.stack([cosine * x - sine * y, sine * x + cosine * y], axis=1)


def increments(path: Array) -> Array:
    """Return the motion from each pose of a path `(K, 3)` to the next, in its frame, `(K - 1, 3)`."""
    steps = np.diff(path, axis=0)
    return np.column_stack([turned(-path[:-1, 2], steps[:, :2]), steps[:, 2]])


def rates(way: Array, time: Array) -> tuple[Array, Array]:
    """Return speed [m/s] and acceleration [m/s^2] in each step, shape `(N - 1,)`, of a way `(N,)` [m]."""
    period = float(np.median(np.diff(time)))
    half, index = max(1, round(0.5 * SMOOTHING / period)), np.arange(len(time))
    before, after = np.maximum(index - half, 0), np.minimum(index + half, len(time) - 1)
    span = time[after] - time[before]
    speed = (way[after] - way[before]) / span
    acceleration = (speed[after] - speed[before]) / span
    return 0.5 * (speed[1:] + speed[:-1]), 0.5 * (acceleration[1:] + acceleration[:-1])
