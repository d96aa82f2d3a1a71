"""Where `omnimate umbmark` takes its experiments from: recordings, a table, OptiOdom folders."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from calib.apply import corrected_vehicle
from calib.errors import CalibrationError
from calib.experiment import (
    Experiment,
    experiment_of_optiodom,
    experiment_of_recordings,
    experiment_of_table,
)
from calib.optiodom import is_optiodom
from calib.recordings import has_fixes
from cli.loading import load

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from vehicle.parameters import TruckName, VehicleParameters
    from vehicle.recording import Recording


@dataclass(frozen=True, slots=True)
class Case:
    """One truck in one experiment.

    Attributes:
        label: how the tables call it.
        truck: which truck of the robot.
        experiment: its runs.
        recordings: that it comes from; empty for a table or an OptiOdom folder.
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

    All recordings together make one experiment for each truck; every table and every OptiOdom folder makes
    one of its own. `vehicle` stands in for the parameters in recordings; a table needs it.

    Raises:
        CalibrationError: a source is none of the three, or does not make an experiment.
    """
    cases: list[Case] = []
    folders: list[Path] = []
    for source in sources:
        if source.is_file():
            cases.append(_table_case(source, truck or "a", side, vehicle))
        elif is_optiodom(source):
            cases.append(Case(source.resolve().name, truck or "a", experiment_of_optiodom(source, side)))
        elif (source / "vehicle.toml").is_file():
            folders.append(source)
        else:
            expected = "a recording folder, a CSV table of return errors, or an OptiOdom folder"
            raise CalibrationError(source, f"expected {expected}")
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
    known = [one for one in recordings[0].vehicle.trucks if any(has_fixes(it, one) for it in recordings)]
    chosen = [truck] if truck is not None else known or [next(iter(recordings[0].vehicle.trucks))]
    return [
        Case(
            f"{label}, truck {one}" if len(recordings[0].vehicle.trucks) > 1 else label,
            one,
            experiment_of_recordings(recordings, one, side),
            tuple(recordings),
        )
        for one in chosen
    ]
