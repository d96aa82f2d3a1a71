"""The true parameters of a simulated robot, as opposed to the nominal ones of `vehicle.toml`."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from omnimate.vcan_sim.errors import SimulationError
from omnimate.vcan_sim.floor import Floor
from omnimate.vehicle.sonar import Sonar

if TYPE_CHECKING:
    from omnimate.effects.effect import Effect
    from omnimate.vehicle.parameters import TruckName, VehicleParameters


# Ratios of true to nominal value of U Fig. 11 [1]; those of truck b are the inverse ones (assumption).
WHEELBASE_ERROR: dict[TruckName, float] = {"a": 336.17 / 340.00, "b": 340.00 / 336.17}
DIAMETER_ERROR: dict[TruckName, float] = {"a": 1.00084, "b": 1.0 / 1.00084}


@dataclass(frozen=True, slots=True)
class Truth:
    """A true robot on its floor.

    Attributes:
        vehicle: True wheel diameters and wheelbases, and the true length of the link at rest.
        floor: Floor on which the robot drives.
        sonar: Sonar that measures the robot's absolute pose.
        stroke: Travel of the slider to either side of its length at rest [m]; 0.15 is an assumption.
        servo: Largest acceleration of a wheel over the floor [m/s^2]; 5 is an assumption.
        seed: Seed of the floor's roughness, of the sonar's noise and of the counters' first values.
        effects: Effects that the nominal robot does not have; at one stage they act in this order.

    Raises:
        SimulationError: The seed is negative, or an effect acts on a component that this robot does not have.
    """

    vehicle: VehicleParameters
    floor: Floor = field(default_factory=Floor)
    sonar: Sonar = field(default_factory=Sonar)
    stroke: float = 0.15
    servo: float = 5.0
    seed: int = 0
    effects: tuple[Effect, ...] = ()

    def __post_init__(self) -> None:
        if self.seed < 0:
            raise SimulationError(f"seed {self.seed}; expected 0 or more")
        components = (*self.vehicle.expected_channels, *self.vehicle.trucks, "poses")
        for effect in self.effects:
            if effect.component not in components:
                raise SimulationError(
                    f"{effect.name}: {self.vehicle.name} has no {effect.component}; "
                    f"expected one of {', '.join(components)}"
                )


def uncalibrated(vehicle: VehicleParameters) -> VehicleParameters:
    """Return a true vehicle whose truck a has the errors of U Fig. 11, and truck b the inverse ones."""
    return with_errors(vehicle, WHEELBASE_ERROR, DIAMETER_ERROR)


def with_errors(
    vehicle: VehicleParameters,
    wheelbase_ratio: dict[TruckName, float],
    diameter_ratio: dict[TruckName, float],
) -> VehicleParameters:
    """Return a true vehicle whose trucks have other wheelbases and unequal wheels.

    Args:
        vehicle: Nominal vehicle.
        wheelbase_ratio: Ratio E_b of each truck whose wheelbase differs, U (2.4).
        diameter_ratio: Ratio E_d = D_R / D_L of each truck whose wheels differ, U (2.3); the mean diameter
            stays, U (4.28).
    """
    for name, truck in vehicle.trucks.items():
        nominal = truck.wheel_diameter_right / truck.wheel_diameter_left
        ratio = diameter_ratio.get(name, nominal)
        mean = 0.5 * (truck.wheel_diameter_left + truck.wheel_diameter_right)
        left = mean * 2.0 / (ratio + 1.0)
        changed = replace(
            truck,
            wheelbase=truck.wheelbase * wheelbase_ratio.get(name, 1.0),
            wheel_diameter_left=left,
            wheel_diameter_right=ratio * left,
        )
        vehicle = vehicle.with_truck(name, changed)
    return vehicle
