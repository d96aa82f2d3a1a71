"""Checks of recordings before a calibration: absolute poses exist, and all are of one robot."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.calib.errors import CalibrationError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.vehicle.parameters import TruckName
    from omnimate.vehicle.recording import Recording


def has_fixes(recording: Recording, truck: TruckName) -> bool:
    """Return whether a recording holds absolute poses of a truck."""
    return recording.poses is not None and bool((recording.poses.body == truck).any())


def check_one_robot(recordings: Sequence[Recording]) -> None:
    """Raise an error if recordings are of robots with different names or channels.

    Raises:
        CalibrationError: A recording is of another robot than the first one.
    """
    for other in recordings[1:]:
        first = recordings[0]
        if (other.vehicle.name, other.vehicle.channels) != (first.vehicle.name, first.vehicle.channels):
            raise CalibrationError(
                other.source,
                f"it is of the robot {other.vehicle.name!r}, but {first.source} of {first.vehicle.name!r}; "
                "give recordings of one robot at a time (its name stands in vehicle.toml)",
            )
