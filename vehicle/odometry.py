"""Dead reckoning with the exact circular arc: over a recording at once, and sample by sample.

A truck moves only in samples in which both of its wheels are present; the step then spans the missing
ones as one arc, so that a late frame never looks like a turn.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from vehicle.errors import RecordingError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from vehicle.parameters import Channel, TruckName, VehicleParameters
    from vehicle.recording import Recording
    from vehicle.sample import Sample
    from vehicle.se2 import Array

_SMALL = 1e-6  # [rad] below this half angle sin(h)/h is 1 - h^2/6 to rounding

PoseTuple = tuple[float, float, float]


def wheel_travel(counts: ArrayLike, metres_per_count: float) -> Array:
    """Return the travel of a wheel [m] for counts of any shape, U (2.2) with c_m of U (2.1), (4.33)."""
    return np.asarray(counts, np.float64) * metres_per_count


def arc(left: ArrayLike, right: ArrayLike, wheelbase: float) -> Array:
    """Return the pose increments `(..., 3)` of a truck, in its own frame, along exact circular arcs.

    Args:
        left: `(...)` travel of the left wheel [m].
        right: `(...)` travel of the right wheel [m].
        wheelbase: [m].
    """
    left, right = np.asarray(left, np.float64), np.asarray(right, np.float64)
    turn = (right - left) / wheelbase
    half = 0.5 * turn
    small = np.abs(half) < _SMALL
    ratio = np.where(small, 1.0 - half * half / 6.0, np.sin(half) / np.where(small, 1.0, half))
    chord = 0.5 * (left + right) * ratio
    return np.stack([chord * np.cos(half), chord * np.sin(half), turn], axis=-1)


def integrate(increments: ArrayLike, start: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
    """Return the poses `(N+1, 3)` that N increments `(N, 3)`, each in the frame before it, lead to."""
    increments, start = np.asarray(increments, np.float64), np.asarray(start, np.float64)
    heading = np.cumsum(np.concatenate(([start[2]], increments[:, 2])))
    cos, sin = np.cos(heading[:-1]), np.sin(heading[:-1])
    x = np.cumsum(np.concatenate(([start[0]], cos * increments[:, 0] - sin * increments[:, 1])))
    y = np.cumsum(np.concatenate(([start[1]], sin * increments[:, 0] + cos * increments[:, 1])))
    return np.stack([x, y, heading], axis=-1)


def truck_travel(recording: Recording, truck: TruckName) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Return the cumulative travel of a truck's wheels [m] and where both were present, each `(N,)`.

    Raises:
        RecordingError: the two wheels are never present together.
    """
    left, right = wheels_of(truck)
    both = recording.is_present(left) & recording.is_present(right)
    if not both.any():
        raise RecordingError(
            recording.source,
            f"wheels {left} and {right} are never there in the same sample; "
            "check node, cob_id and start_bit of both in vehicle.toml",
        )
    held = np.maximum.accumulate(np.where(both, np.arange(len(both)), int(np.argmax(both))))
    vehicle = recording.vehicle
    travel = [
        wheel_travel(recording.channel_counts(wheel)[held], vehicle.metres_per_count(wheel))
        for wheel in (left, right)
    ]
    return travel[0], travel[1], both


def dead_reckon(recording: Recording, truck: TruckName = "a", start: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
    """Return the poses `(N, 3)` of a truck at every sample of a recording, from its wheels alone.

    Raises:
        RecordingError: as `truck_travel`.
    """
    left, right, _ = truck_travel(recording, truck)
    wheelbase = recording.vehicle.trucks[truck].wheelbase
    return integrate(arc(np.diff(left), np.diff(right), wheelbase), start)


def wheels_of(truck: TruckName) -> tuple[Channel, Channel]:
    """Return the channels of a truck's left and right wheel."""
    return ("a.left", "a.right") if truck == "a" else ("b.left", "b.right")


class Odometer:
    """Dead reckoning of one truck, sample by sample; agrees with `dead_reckon` to rounding.

    Attributes:
        pose: x [m], y [m], theta [rad] after the last sample.
    """

    def __init__(
        self, vehicle: VehicleParameters, truck: TruckName = "a", start: PoseTuple = (0.0, 0.0, 0.0)
    ) -> None:
        left, right = wheels_of(truck)
        self.pose = start
        self._columns = vehicle.channels.index(left), vehicle.channels.index(right)
        self._scales = vehicle.metres_per_count(left), vehicle.metres_per_count(right)
        self._wheelbase = vehicle.trucks[truck].wheelbase
        self._before: tuple[int, int] | None = None

    def step(self, sample: Sample) -> PoseTuple:
        """Take one sample and return the pose after it."""
        left, right = self._columns
        if not (sample.present[left] and sample.present[right]):
            return self.pose
        now = sample.counts[left], sample.counts[right]
        if self._before is not None:
            travel_left = (now[0] - self._before[0]) * self._scales[0]
            travel_right = (now[1] - self._before[1]) * self._scales[1]
            self.pose = advance(self.pose, travel_left, travel_right, self._wheelbase)
        self._before = now
        return self.pose


def advance(pose: PoseTuple, left: float, right: float, wheelbase: float) -> PoseTuple:
    """Return the pose after one exact arc: `arc` and `integrate` for a single step of plain floats."""
    turn = (right - left) / wheelbase
    half = 0.5 * turn
    ratio = 1.0 - half * half / 6.0 if abs(half) < _SMALL else math.sin(half) / half
    chord = 0.5 * (left + right) * ratio
    x, y, theta = pose
    return x + chord * math.cos(theta + half), y + chord * math.sin(theta + half), theta + turn
