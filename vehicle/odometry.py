"""Dead reckoning with the exact circular arc: over a recording at once, and sample by sample.

A truck moves only in samples in which both of its wheels are present; the step spans the samples between as
one arc, so that a late frame is not mistaken for a turn.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omnimate.vehicle.arcs import PoseTuple, advance, arc, integrate
from omnimate.vehicle.errors import RecordingError
from omnimate.vehicle.se2 import wrap

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from omnimate.vehicle.parameters import Channel, TruckName, VehicleParameters
    from omnimate.vehicle.recording import Recording
    from omnimate.vehicle.sample import Sample
    from omnimate.vehicle.se2 import Array

MILLIMETRES = 1000.0**0.5  # times what the wheels roll: nearer to millimetres than to metres
# Headings at random differ from those of the wheels by 1.8 rad (pi / sqrt 3), and after a turn of a radian
# those of a wheelbase that is wrong by a quarter by 0.25 rad.
EQUAL_HEADINGS, RANDOM_HEADINGS = 0.3, 1.0  # [rad]
MIN_STEPS = 3  # of a metre, or a radian


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


def check_pose_units(recording: Recording, truck: TruckName) -> None:
    """Raise an error where a truck's absolute poses can only be in millimetres, or in degrees.

    No truck gets farther than its wheels roll. Headings in degrees turn as the wheels say once they are
    converted, and at random as they are.

    Raises:
        RecordingError: They are, or the two wheels of a truck with poses are never present together.
    """
    poses = None if recording.poses is None else recording.poses.of(truck)
    if poses is None or len(poses.time) == 0:
        return
    wheels = dead_reckon(recording, truck)
    steps = np.abs(np.diff(wheels, axis=0, prepend=wheels[:1])).T
    travel, turn = np.cumsum(np.hypot(steps[0], steps[1])), np.cumsum(steps[2])
    rolled, turned, heading = (
        np.interp(poses.time, recording.time, column) for column in (travel, turn, wheels[:, 2])
    )
    apart = _one_apart(rolled, np.isfinite(poses.pose[:, 0] + poses.pose[:, 1]))
    ratios = np.hypot(*np.diff(poses.pose[apart, :2], axis=0).T) / np.diff(rolled[apart])
    if len(ratios) >= MIN_STEPS and np.median(ratios) > MILLIMETRES:
        raise RecordingError(
            recording.source,
            f"the poses of truck {truck} move by {np.median(ratios):.0f} where its wheels roll 1 m; "
            "expected x and y in metres, not in millimetres",
        )
    apart = _one_apart(turned, np.isfinite(poses.pose[:, 2]))
    turns, expected = np.diff(poses.pose[apart, 2]), np.diff(heading[apart])
    if len(turns) < MIN_STEPS:
        return
    as_read, converted = (np.std(wrap(angles - expected)) for angles in (turns, np.radians(turns)))
    if converted < EQUAL_HEADINGS and as_read > RANDOM_HEADINGS:
        raise RecordingError(
            recording.source,
            f"the headings of truck {truck} turn as its wheels say if they are taken for degrees; "
            "expected theta in radians",
        )


def _one_apart(amount: Array, known: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return the known rows `(M,)` at which an amount `(M,)` that grows passes a whole number."""
    rows = np.flatnonzero(known)
    return rows[np.diff(np.floor(amount[rows]), prepend=-1.0) > 0.0]


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
