"""Square runs from recordings: a fix before each lap, a fix after it, and the turns of the wheels between."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.calib.errors import CalibrationError
from omnimate.calib.fixes import WheelsAndFixes
from omnimate.calib.recordings import has_fixes
from omnimate.calib.umbmark.runs import SquareRun
from omnimate.vehicle.se2 import between

if TYPE_CHECKING:
    from omnimate.vehicle.parameters import TruckName
    from omnimate.vehicle.recording import Recording


def square_runs(recording: Recording, truck: TruckName = "a") -> tuple[SquareRun, ...]:
    """Return a run for each cw or ccw lap of a recording.

    The fix before is the last one at rest before the lap, the fix after the first one at rest after it; all
    fixes of the same rest are averaged with their inverse variances. The wheels count between exactly these.

    Raises:
        CalibrationError: The recording has no laps, or no absolute poses of this truck.
        FixError: A lap has no fix before or after it.
    """
    if recording.run is None:
        raise CalibrationError(recording.source, "no run.toml; UMBmark needs the laps and their directions")
    if truck not in recording.vehicle.trucks:
        raise CalibrationError(recording.source, f"the robot has no truck {truck}")
    if recording.poses is None or not has_fixes(recording, truck):
        raise CalibrationError(
            recording.source, f"poses.csv has no pose of truck {truck}; UMBmark needs fixes"
        )
    drive = WheelsAndFixes(recording, truck, recording.poses.of(truck))
    runs = []
    for number, lap in enumerate(recording.run.laps, start=1):
        if lap.direction == "none":
            continue
        source = f"{recording.source}, lap {number}, truck {truck}"
        start, first = drive.fix_before(lap.start, source)
        end, last = drive.fix_after(lap.end, source)
        runs.append(SquareRun(lap.direction, between(first, last), drive.wheel_angles(start, end), source))
    return tuple(runs)
