"""What `omnimate umbmark` hands on: a calibrated vehicle.toml, a profile, and other people's formats."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.calib.apply import corrected_vehicle
from omnimate.calib.errors import CalibrationError
from omnimate.calib.exports import calibration_json, ros2_yaml, vda5050_json
from omnimate.calib.umbmark.floor import floor_roughness
from omnimate.calib.umbmark.uncertainty import uncertainty_of
from omnimate.cli.options import Format

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.calib.umbmark.experiment import Calibration
    from omnimate.calib.umbmark.uncertainty import Interval, Uncertainty
    from omnimate.cli.umbmark.results import Result
    from omnimate.vehicle.parameters import Truck, TruckName, VehicleParameters


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
