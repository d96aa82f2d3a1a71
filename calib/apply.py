"""Corrected parameters of trucks and robots.

The mean wheel diameter is held: it is assumed to be measured with a tape, see `omnimate.calib.scale`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from omnimate.vehicle.parameters import Truck

if TYPE_CHECKING:
    from collections.abc import Mapping

    from omnimate.vehicle.parameters import TruckName, VehicleParameters


def corrected_truck(truck: Truck, e_b: float, e_d: float) -> Truck:
    """Return a truck with its wheelbase times E_b and its ratio D_R / D_L times E_d, U (4.26)-(4.30).

    Factors of successive calibrations multiply.

    Raises:
        ParameterError: The result is not a possible truck.
    """
    mean = 0.5 * (truck.wheel_diameter_left + truck.wheel_diameter_right)
    ratio = e_d * truck.wheel_diameter_right / truck.wheel_diameter_left
    return Truck(
        wheelbase=truck.wheelbase * e_b,
        wheel_diameter_left=2.0 * mean / (ratio + 1.0),
        wheel_diameter_right=2.0 * mean / (1.0 / ratio + 1.0),
    )


@dataclass(frozen=True, slots=True)
class Factors:
    """Factors between two sets of parameters of a truck."""

    e_b: float  # factor between the wheelbases, U (2.4)
    e_d: float  # factor between the ratios D_R / D_L, U (2.3)
    c_left: float  # factor between the left diameters, U (4.33); (4.31) where both were equal
    c_right: float  # factor between the right diameters, U (4.33); (4.32) where both were equal


def factors_between(first: Truck, last: Truck) -> Factors:
    """Return the factors from the first parameters to the last, of one pass or of all together."""
    left = last.wheel_diameter_left / first.wheel_diameter_left
    right = last.wheel_diameter_right / first.wheel_diameter_right
    return Factors(last.wheelbase / first.wheelbase, right / left, left, right)


def corrected_vehicle(vehicle: VehicleParameters, trucks: Mapping[TruckName, Truck]) -> VehicleParameters:
    """Return the same robot with the named trucks replaced by calibrated ones."""
    for name, truck in trucks.items():
        vehicle = vehicle.with_truck(name, truck)
    return vehicle
