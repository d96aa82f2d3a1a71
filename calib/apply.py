"""Corrected parameters; the mean wheel diameter is held, because it was measured before, with a tape."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vehicle.parameters import Truck

if TYPE_CHECKING:
    from collections.abc import Mapping

    from vehicle.parameters import TruckName, VehicleParameters


def corrected_truck(truck: Truck, e_b: float, e_d: float) -> Truck:
    """Return a truck with its wheelbase times E_b and its ratio D_R / D_L times E_d, U (4.26)-(4.30).

    A second pass thereby multiplies the factors of the first.

    Raises:
        ParameterError: no robot can have the result.
    """
    mean = 0.5 * (truck.wheel_diameter_left + truck.wheel_diameter_right)
    ratio = e_d * truck.wheel_diameter_right / truck.wheel_diameter_left
    return Truck(
        wheelbase=truck.wheelbase * e_b,
        wheel_diameter_left=2.0 * mean / (ratio + 1.0),
        wheel_diameter_right=2.0 * mean / (1.0 / ratio + 1.0),
    )


def corrected_vehicle(vehicle: VehicleParameters, trucks: Mapping[TruckName, Truck]) -> VehicleParameters:
    """Return the same robot with calibrated trucks in place of those named."""
    for name, truck in trucks.items():
        vehicle = vehicle.with_truck(name, truck)
    return vehicle
