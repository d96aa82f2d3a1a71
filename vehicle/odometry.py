"""Dead reckoning with the exact circular arc: over a recording at once, and sample by sample.

A truck moves only in samples in which both of its wheels are present; the step spans the samples between as
one arc, so that a late frame is not mistaken for a turn.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omnimate.vehicle.arcs import PoseTuple, advance, arc, integrate
from omnimate.vehicle.errors import RecordingError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from omnimate.vehicle.parameters import Channel, TruckName, VehicleParameters
    from omnimate.vehicle.recording import Recording
    from omnimate.vehicle.sample import Sample
    from omnimate.vehicle.se2 import Array


def truck_travel(recording: Recording, truck: TruckName) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Return the cumulative travel of a truck's wheels [m] and where both were present, each `(N,)`.

    The travel is that of U (2.2), with c_m of U (2.1), (4.33).

    Raises:
        RecordingError: The two wheels are never present together.
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
    travel_left, travel_right = (
        recording.channel_counts(wheel)[held].astype(np.float64) * recording.vehicle.metres_per_count(wheel)
        for wheel in (left, right)
    )
    return travel_left, travel_right, both


def dead_reckon(recording: Recording, truck: TruckName = "a", start: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
    """Return the poses `(N, 3)` of a truck at every sample of a recording, from its wheels alone.

    Raises:
        RecordingError: The robot has no such truck, or its two wheels are never present together.
    """
    left, right, _ = truck_travel(recording, truck)
    wheelbase = recording.vehicle.trucks[truck].wheelbase
    return integrate(arc(np.diff(left), np.diff(right), wheelbase), start)


def wheels_of(truck: TruckName) -> tuple[Channel, Channel]:
    """Return the channels of a truck's left and right wheel."""
    return ("a.left", "a.right") if truck == "a" else ("b.left", "b.right")


class Odometer:
    """Dead reckoning of one truck, sample by sample; agrees with `dead_reckon` to rounding.

    `pose` is that after the last sample: x [m], y [m], theta [rad].
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
        """Process one sample and return the pose after it."""
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
