"""What the tool finds in recordings of real robots, about whose physics the truth is not known."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from omnimate.calib.paths.kinematics import Differential
from omnimate.importers import husky, labyrinth
from omnimate.importers.optiodom.drives import read_set
from omnimate.importers.optiodom.recordings import differential_sets, recordings_of
from omnimate.importers.optiodom.scores import calibrate_squares
from omnimate.mismatch import diagnose
from omnimate.mismatch.first_look import first_look
from omnimate.mismatch.rerun import open_loop

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from pathlib import Path

    from omnimate.importers.optiodom.drives import DriveSet
    from omnimate.mismatch import Diagnosis
    from omnimate.vehicle.parameters import Truck
    from omnimate.vehicle.recording import Recording


@dataclass(frozen=True, slots=True)
class SetRow:
    """One OptiOdom set: what each way to better numbers leaves, on drives that it has not seen.

    Attributes:
        name: Path and date of the set, `path/date`.
        diagnosis: Diagnosis of the nominal robot against the set's runs.
        nominal: Position error of the robot as described, 10 s open loop, rms [m].
        calibrated: The same error of the least-squares calibration on the squares of other sets [m].
        found: The same error with the effects that the diagnosis fitted to the set's other runs [m].
    """

    name: str
    diagnosis: Diagnosis
    nominal: float
    calibrated: float
    found: float


@dataclass(frozen=True, slots=True)
class RobotRow:
    """One robot that is described wrongly: as it is described, and as the first look corrects it.

    Attributes:
        name: Name of the data.
        recordings: The recordings with the robot as described.
        corrected: The recordings with the robot as the first look corrects it.
        first: Diagnosis of the robot as described.
        second: Diagnosis of the corrected robot.
    """

    name: str
    recordings: Sequence[Recording]
    corrected: Sequence[Recording]
    first: Diagnosis
    second: Diagnosis


def optiodom_rows(folder: Path, only: str = "") -> Iterator[SetRow]:
    """Yield a row for each differential OptiOdom set whose path/date has `only` in it.

    Raises:
        OptiOdomError: A set is damaged.
    """
    sets, _ = differential_sets(folder)
    drives = {place: read_set(place) for place in sets}
    trucks: dict[str, Truck] = {}
    for place in sets:
        name = f"{place.parent.name}/{place.name}"
        if only not in name:
            continue
        left_out = place.name if drives[place].path == "square" else ""
        if left_out not in trucks:
            trucks[left_out] = _calibrated(drives, left_out)
        recordings = recordings_of(place)
        diagnosis = diagnose(recordings)
        assert diagnosis.fit is not None  # every set has poses and minutes of driving
        loop = diagnosis.fit.rerun["a position"]
        better = [
            replace(recording, vehicle=recording.vehicle.with_truck("a", trucks[left_out]))
            for recording in recordings
        ]
        yield SetRow(name, diagnosis, loop.before, open_loop(better)["a position"], loop.after)


def _calibrated(drives: Mapping[Path, DriveSet], left_out: str) -> Truck:
    """Return the truck of the least-squares calibration on all squares but those of one date."""
    sets = [drive for place, drive in drives.items() if place.name != left_out]
    kinematics = calibrate_squares(sets).kinematics
    assert isinstance(kinematics, Differential)  # as all of the sets are
    return kinematics.truck


def robot_row(folder: Path, every: int = 1) -> RobotRow:
    """Return the answers to labyrinth_tuc or drive_ugv, as described and as corrected by the first look.

    Args:
        folder: Folder of the data, whose name says which of the two they are.
        every: One in so many of the corrected recordings is searched.

    Raises:
        SourceError: The data are damaged.
    """
    source = labyrinth if folder.name == "labyrinth_tuc" else husky
    recordings = source.recordings_of(folder)
    look = first_look(recordings)
    corrected = recordings if look is None else [look.corrected(recording) for recording in recordings]
    return RobotRow(folder.name, recordings, corrected, diagnose(recordings), diagnose(corrected[::every]))
