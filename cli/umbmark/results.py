"""The calibration of each truck by `omnimate umbmark`: whether to use it, and in which formats."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from omnimate.calib.apply import corrected_vehicle
from omnimate.calib.errors import CalibrationError
from omnimate.calib.exports import calibration_json, ros2_yaml, vda5050_json
from omnimate.calib.scale import scaled_truck
from omnimate.calib.umbmark.assessment import assess
from omnimate.calib.umbmark.floor import floor_roughness
from omnimate.calib.umbmark.uncertainty import uncertainty_of
from omnimate.cli.console import warn
from omnimate.cli.options import Format

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.calib.umbmark.assessment import Assessment
    from omnimate.calib.umbmark.experiment import Calibration
    from omnimate.calib.umbmark.printed import Method
    from omnimate.calib.umbmark.uncertainty import Interval, Uncertainty
    from omnimate.cli.umbmark.sources import Case
    from omnimate.vehicle.parameters import Truck, TruckName, VehicleParameters


@dataclass(frozen=True, slots=True)
class Result:
    """One truck's calibration.

    Attributes:
        case: The truck and its experiment.
        assessment: The calibrations by every method, and the advice.
        chosen: The calibration by the method that was asked for.
        truck: The calibrated truck, scaled by E_s where a tape measured it.
    """

    case: Case
    assessment: Assessment
    chosen: Calibration
    truck: Truck


def result_of(case: Case, method: Method, e_s: float) -> Result:
    """Return what an experiment says, by every method and by the one asked for.

    Raises:
        MethodError: The data do not allow the method.
        CalibrationError: The errors are beyond what a method can explain.
    """
    assessment = assess(case.experiment, case.recordings, case.truck)
    chosen = assessment.by(method)
    return Result(case, assessment, chosen, scaled_truck(chosen.truck, e_s))


def heed_advice(results: Sequence[Result], *, force: bool) -> None:
    """Print what looks wrong.

    Raises:
        CalibrationError: A result is not to be used, and `force` does not say to use it nevertheless.
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
    kind: Format, results: Sequence[Result], robot: VehicleParameters | None, wheel_width: float | None
) -> str:
    """Return the calibration in a format.

    Raises:
        CalibrationError: what the format needs is not known.
    """
    if kind is Format.json:
        return calibration_json([_known(result) for result in results])
    if kind is Format.ros2:
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
