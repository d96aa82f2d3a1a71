"""What `omnimate umbmark` hands on: a calibrated vehicle.toml, a profile, and other people's formats."""

from __future__ import annotations

from typing import TYPE_CHECKING

from calib.apply import corrected_vehicle
from calib.errors import CalibrationError
from calib.exports import calibration_json, ros2_yaml, vda5050_json
from calib.floor import floor_roughness
from calib.uncertainty import uncertainty_of
from cli.choices import Format

if TYPE_CHECKING:
    from collections.abc import Sequence

    from calib.experiment import Calibration
    from calib.uncertainty import Interval, Uncertainty
    from cli.umbmark_results import Result
    from vehicle.parameters import Truck, TruckName, VehicleParameters


def calibrated_trucks(results: Sequence[Result]) -> dict[TruckName, Truck]:
    """Return the calibrated trucks by name.

    Raises:
        CalibrationError: two experiments want the same truck.
    """
    trucks: dict[TruckName, Truck] = {}
    for one in results:
        if one.case.truck in trucks:
            raise CalibrationError(
                one.case.experiment.source,
                f"a second experiment for truck {one.case.truck}; what is written has room for one each",
            )
        trucks[one.case.truck] = one.truck
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
        return calibration_json([_known(one) for one in results])
    if kind is Format.ros2:
        nominal = {one.case.truck: one.case.experiment.truck for one in results}
        return ros2_yaml({name: (nominal[name], truck) for name, truck in calibrated_trucks(results).items()})
    if wheel_width is None:
        raise CalibrationError("--export vda5050", "a factsheet wants it: give --wheel-width, in metres")
    return vda5050_json(calibrated_vehicle(results, robot), wheel_width)


def _known(one: Result) -> tuple[str, Calibration, Truck, Uncertainty, Interval]:
    roughness = floor_roughness(one.chosen.experiment.errors, one.chosen.truck.wheelbase)
    return one.case.label, one.chosen, one.truck, uncertainty_of(one.chosen), roughness
