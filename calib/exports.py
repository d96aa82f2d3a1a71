"""A calibration as ROS 2 parameters, VDA 5050 wheel definitions and JSON.

ros2_controllers' diff_drive_controller multiplies: its left wheel has wheel_radius times
left_wheel_radius_multiplier, its base wheel_separation times wheel_separation_multiplier. A VDA 5050
factsheet lists wheelDefinitions: where each wheel stands in the robot's frame, its diameter and its width.
"""

from __future__ import annotations

import json
import math
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from omnimate.calib.errors import CalibrationError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from omnimate.calib.umbmark.experiment import Calibration
    from omnimate.calib.umbmark.uncertainty import Interval, Uncertainty
    from omnimate.vehicle.parameters import Truck, TruckName, VehicleParameters


def ros2_parameters(nominal: Truck, calibrated: Truck) -> dict[str, float]:
    """Return the parameters of diff_drive_controller: nominal sizes [m] and their multipliers."""
    radius = 0.25 * (nominal.wheel_diameter_left + nominal.wheel_diameter_right)
    return {
        "wheel_separation": nominal.wheelbase,
        "wheel_radius": radius,
        "wheel_separation_multiplier": calibrated.wheelbase / nominal.wheelbase,
        "left_wheel_radius_multiplier": 0.5 * calibrated.wheel_diameter_left / radius,
        "right_wheel_radius_multiplier": 0.5 * calibrated.wheel_diameter_right / radius,
    }


def ros2_yaml(trucks: Mapping[TruckName, tuple[Truck, Truck]]) -> str:
    """Return a ROS 2 parameter file for nominal and calibrated trucks; one controller for each truck."""
    lines = []
    for name, (nominal, calibrated) in trucks.items():
        controller = "diff_drive_controller" if len(trucks) == 1 else f"diff_drive_controller_{name}"
        lines += [f"{controller}:", "  ros__parameters:"]
        lines += [f"    {key}: {value:.9g}" for key, value in ros2_parameters(nominal, calibrated).items()]
    return "\n".join(lines) + "\n"


def vda5050_wheels(vehicle: VehicleParameters, wheel_width: float) -> list[dict[str, object]]:
    """Return the wheelDefinitions of a VDA 5050 factsheet; the frame is that of truck a's drive axle.

    VDA 5050 requires the width of the wheels [m], which a calibration does not give.

    Raises:
        CalibrationError: The width is not between 0 and 1 m.
    """
    if not 0.0 < wheel_width < 1.0:
        raise CalibrationError("--wheel-width", f"{wheel_width} m; expected the width of a wheel in metres")
    wheels = []
    for name, truck in vehicle.trucks.items():
        behind = 0.0 if name == "a" or vehicle.linkage is None else -vehicle.linkage.length
        for sign, diameter in ((1.0, truck.wheel_diameter_left), (-1.0, truck.wheel_diameter_right)):
            wheel: dict[str, object] = {
                "type": "DRIVE",
                "isActiveDriven": True,
                "isActiveSteered": False,
                "position": {"x": behind, "y": sign * 0.5 * truck.wheelbase, "theta": 0.0},
                "diameter": diameter,
                "width": wheel_width,
            }
            wheels.append(wheel)
    return wheels


def vda5050_json(vehicle: VehicleParameters, wheel_width: float) -> str:
    """Return the wheelDefinitions as JSON, for the geometry of a VDA 5050 factsheet."""
    return _json({"wheelDefinitions": vda5050_wheels(vehicle, wheel_width)})


def calibration_json(results: Sequence[tuple[str, Calibration, Truck, Uncertainty, Interval]]) -> str:
    """Return calibrations with their uncertainties as JSON in SI units.

    Each has its label, the calibration, the final truck (with E_s where it was measured), the uncertainty of
    the calibration, and the floor's roughness [m/sqrt(m)].
    """
    return _json([_result(*result) for result in results])


def _result(
    label: str, calibration: Calibration, truck: Truck, uncertainty: Uncertainty, roughness: Interval
) -> dict[str, object]:
    correction, errors, factors = calibration.correction, calibration.experiment.errors, calibration.factors
    values = ("e_b", "e_d", "wheelbase", "diameter_left", "diameter_right")
    return {
        "experiment": label,
        "method": correction.method,
        "runs": {"cw": len(errors.cw), "ccw": len(errors.ccw)},
        "side": errors.side,
        "alpha": correction.alpha,
        "beta": correction.beta,
        "c_left": factors.c_left,
        "c_right": factors.c_right,
        "confidence": uncertainty.confidence,
        **{key: asdict(getattr(uncertainty, key)) for key in values},
        "covariance_of_e_b_and_e_d": uncertainty.covariance.tolist(),
        "e_max_syst": {"before": errors.e_max_syst, "after": calibration.errors.e_max_syst},
        "scatter": errors.scatter,
        "roughness": asdict(roughness),
        "e_s": truck.wheelbase / calibration.truck.wheelbase,
        "truck": asdict(truck),
        "ros2": ros2_parameters(calibration.experiment.truck, truck),
    }


def _json(document: object) -> str:
    """Return JSON; numbers that are not finite become null."""
    return json.dumps(_known(document), indent=2) + "\n"


def _known(value: Any) -> Any:  # noqa: ANN401  # whatever JSON can hold
    if isinstance(value, dict):
        return {key: _known(entry) for key, entry in value.items()}
    if isinstance(value, list):
        return [_known(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
