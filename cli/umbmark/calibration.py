"""From the sources of `omnimate umbmark` to the calibration of each truck, and whether to use it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from omnimate.calib.apply import corrected_vehicle
from omnimate.calib.errors import CalibrationError
from omnimate.calib.exports import calibration_json, ros2_yaml, vda5050_json
from omnimate.calib.recordings import has_fixes
from omnimate.calib.scale import scaled_truck
from omnimate.calib.umbmark.assessment import assess
from omnimate.calib.umbmark.experiment import Experiment, experiment_of_recordings, experiment_of_table
from omnimate.calib.umbmark.floor import floor_roughness
from omnimate.calib.umbmark.uncertainty import uncertainty_of
from omnimate.cli.console import warn
from omnimate.cli.loading import load
from omnimate.files.recordings.folder import VEHICLE, log_path

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from omnimate.calib.umbmark.assessment import Assessment
    from omnimate.calib.umbmark.experiment import Calibration
    from omnimate.calib.umbmark.printed import Method
    from omnimate.calib.umbmark.uncertainty import Interval, Uncertainty
    from omnimate.cli.options import ExportFormat
    from omnimate.vehicle.parameters import Truck, TruckName, VehicleParameters
    from omnimate.vehicle.recording import Recording


LOG_SUFFIXES = {".asc", ".blf", ".log", ".mf4", ".pcap", ".pcapng", ".trc"}


@dataclass(frozen=True, slots=True)
class Case:
    """One truck in one experiment.

    The label is what the tables call it; a table has no recordings.
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

    All recordings together make one experiment for each truck; every table makes one of its own. `vehicle`
    stands in for the parameters in recordings; a table needs it.

    Raises:
        CalibrationError: a source is neither, or does not make an experiment.
    """
    cases: list[Case] = []
    folders: list[Path] = []
    for given in sources:
        source = _folder_of_log(given)
        if source.is_file():
            cases.append(_table_case(source, truck or "a", side, vehicle))
        elif (source / VEHICLE).is_file():
            folders.append(source)
        else:
            raise CalibrationError(source, "expected a recording folder or a CSV table of return errors")
    recordings = [_with_trucks(load(folder), vehicle) for folder in folders]
    if recordings:
        cases = _recording_cases(recordings, folders[0].resolve().name, truck, side) + cases
        vehicle = vehicle or recordings[0].vehicle
    return cases, vehicle


def _folder_of_log(source: Path) -> Path:
    """Return the recording folder whose log is given; else the source."""
    if not LOG_SUFFIXES & set(source.suffixes):
        return source
    if (source.parent / VEHICLE).is_file():
        own = log_path(source.parent)
        if source.name == own.name:
            return source.parent
        raise CalibrationError(
            source, f"the log of the recording folder {source.parent} is {own.name}; give that or the folder"
        )
    raise CalibrationError(
        source,
        "a log alone has neither laps nor absolute poses: give the recording folder that `omnimate record` "
        "or `omnimate import log` writes, with poses.csv and run.toml",
    )


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
    recordings: list[Recording], source: str, truck: TruckName | None, side: float | None
) -> list[Case]:
    """Return one case for the truck asked for, or for each one of which there are fixes."""
    label = source if len(recordings) == 1 else f"{source} and {len(recordings) - 1} more"
    trucks = recordings[0].vehicle.trucks
    known = [name for name in trucks if any(has_fixes(recording, name) for recording in recordings)]
    chosen = [truck] if truck is not None else known or [next(iter(trucks))]
    return [
        Case(
            f"{label}, truck {name}" if len(trucks) > 1 else label,
            name,
            experiment_of_recordings(recordings, name, side),
            tuple(recordings),
        )
        for name in chosen
    ]


@dataclass(frozen=True, slots=True)
class Result:
    """One truck's calibration.

    `chosen` is by the method that was asked for; the truck is scaled by E_s where a tape measured it.
    """

    case: Case
    assessment: Assessment
    chosen: Calibration
    truck: Truck


def result_of(case: Case, method: Method, e_s: float) -> Result:
    """Return the calibrations of an experiment by every method, and by the one asked for.

    Raises:
        MethodError: The data do not allow the method.
        CalibrationError: The errors are beyond what a method can explain.
    """
    assessment = assess(case.experiment, case.recordings, case.truck)
    chosen = assessment.by(method)
    case = replace(case, experiment=assessment.experiment)
    return Result(case, assessment, chosen, scaled_truck(chosen.truck, e_s))


def print_advice(results: Sequence[Result], *, force: bool) -> None:
    """Print the warnings about the data.

    Raises:
        CalibrationError: A result must not be used, and `force` is not given.
    """
    errors = []
    for result in results:
        source = result.case.experiment.source
        for advice in result.assessment.advice:
            if advice.severity == "error" and not force:
                errors.append(str(advice).removeprefix(f"{source}: "))
            else:
                warn(f"{result.case.label}: {advice}")
    if errors:
        sentences = "; ".join(dict.fromkeys(errors))
        raise CalibrationError(
            results[0].case.experiment.source, f"{sentences} (--force uses the result nevertheless)"
        )


def calibrated_trucks(results: Sequence[Result]) -> dict[TruckName, Truck]:
    """Return the calibrated trucks by name.

    Raises:
        CalibrationError: two experiments want the same truck.
    """
    trucks: dict[TruckName, Truck] = {}
    for result in results:
        if result.case.truck in trucks:
            raise CalibrationError(
                result.case.experiment.source,
                f"a second experiment for truck {result.case.truck}; only one for each truck can be written",
            )
        trucks[result.case.truck] = result.truck
    return trucks


def calibrated_vehicle(results: Sequence[Result], robot: VehicleParameters | None) -> VehicleParameters:
    """Return the robot with its calibrated trucks.

    Raises:
        CalibrationError: the robot is not known, or two experiments want the same truck.
    """
    if robot is None:
        raise CalibrationError(
            results[0].case.experiment.source,
            "it holds no vehicle.toml to calibrate: give --vehicle vehicle.toml",
        )
    return corrected_vehicle(robot, calibrated_trucks(results))


def export(
    kind: ExportFormat, results: Sequence[Result], robot: VehicleParameters | None, wheel_width: float | None
) -> str:
    """Return the calibration in a format.

    Raises:
        CalibrationError: what the format needs is not known.
    """
    if kind == "json":
        return calibration_json([_known(result) for result in results])
    if kind == "ros2":
        nominal = {result.case.truck: result.case.experiment.truck for result in results}
        return ros2_yaml({name: (nominal[name], truck) for name, truck in calibrated_trucks(results).items()})
    if wheel_width is None:
        raise CalibrationError(
            "--export vda5050", "a factsheet states the width of a wheel: give --wheel-width, in metres"
        )
    return vda5050_json(calibrated_vehicle(results, robot), wheel_width)


def _known(result: Result) -> tuple[str, Calibration, Truck, Uncertainty, Interval]:
    roughness = floor_roughness(result.chosen.experiment.errors, result.chosen.truck.wheelbase)
    return result.case.label, result.chosen, result.truck, uncertainty_of(result.chosen), roughness
