"""Where `omnimate umbmark` takes its experiments from: recordings, or a table."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from omnimate.calib.apply import corrected_vehicle
from omnimate.calib.errors import CalibrationError
from omnimate.calib.recordings import has_fixes
from omnimate.calib.umbmark.experiment import Experiment, experiment_of_recordings, experiment_of_table
from omnimate.cli.loading import load

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from omnimate.vehicle.parameters import TruckName, VehicleParameters
    from omnimate.vehicle.recording import Recording


@dataclass(frozen=True, slots=True)
class Case:
    """One truck in one experiment.

    Attributes:
        label: What the tables call it.
        truck: The truck of the robot.
        experiment: Its experiment.
        recordings: The recordings of the experiment; empty for a table.
    """

    label: str
    truck: TruckName
    experiment: Experiment
    recordings: tuple[Recording, ...] = ()


def load_cases(
    sources: Sequence[Path],
    truck: TruckName | None,
    side: float | None,
    vehicle: VehicleParameters | None,
) -> tuple[list[Case], VehicleParameters | None]:
    """Return the experiments of all sources, and the robot that they are about where it is known.

    All recordings together make one experiment for each truck; every table makes one of
    its own. `vehicle` stands in for the parameters in recordings; a table needs it.

    Raises:
        CalibrationError: a source is neither, or does not make an experiment.
    """
    cases: list[Case] = []
    folders: list[Path] = []
    for source in sources:
        if source.is_file():
            cases.append(_table_case(source, truck or "a", side, vehicle))
        elif (source / "vehicle.toml").is_file():
            folders.append(source)
        else:
            raise CalibrationError(source, "expected a recording folder or a CSV table of return errors")
    recordings = [_with_trucks(load(folder), vehicle) for folder in folders]
    if recordings:
        cases = _recording_cases(recordings, folders[0].resolve().name, truck, side) + cases
        vehicle = vehicle or recordings[0].vehicle
    return cases, vehicle


def _table_case(path: Path, truck: TruckName, side: float | None, vehicle: VehicleParameters | None) -> Case:
    if side is None:
        raise CalibrationError(path, "a table does not say the side of its square: give --side, in metres")
    if vehicle is None:
        raise CalibrationError(
            path, "a table does not say the nominal wheelbase: give --vehicle vehicle.toml"
        )
    if truck not in vehicle.trucks:
        raise CalibrationError(path, f"the robot {vehicle.name} has no truck {truck}")
    return Case(path.name, truck, experiment_of_table(path, vehicle.trucks[truck], side))


def _with_trucks(recording: Recording, vehicle: VehicleParameters | None) -> Recording:
    """Return a recording whose trucks have the parameters of another `vehicle.toml`."""
    if vehicle is None:
        return recording
    if vehicle.trucks.keys() != recording.vehicle.trucks.keys():
        raise CalibrationError(recording.source, f"it is of another robot than {vehicle.name} in --vehicle")
    return replace(recording, vehicle=corrected_vehicle(recording.vehicle, vehicle.trucks))


def _recording_cases(
    recordings: list[Recording], name: str, truck: TruckName | None, side: float | None
) -> list[Case]:
    """Return one case for the truck asked for, or for each one of which there are fixes."""
    label = name if len(recordings) == 1 else f"{name} and {len(recordings) - 1} more"
    trucks = recordings[0].vehicle.trucks
    known = [each for each in trucks if any(has_fixes(recording, each) for recording in recordings)]
    chosen = [truck] if truck is not None else known or [next(iter(trucks))]
    return [
        Case(
            f"{label}, truck {each}" if len(trucks) > 1 else label,
            each,
            experiment_of_recordings(recordings, each, side),
            tuple(recordings),
        )
        for each in chosen
    ]
