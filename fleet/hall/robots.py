"""The robots of a hall: of three types, with nominal variation, wear and faults."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from omnimate.fleet.hall.faults import WheelFaults
from omnimate.vcan_sim.biases import linkage_biases
from omnimate.vcan_sim.reference import reference_single, reference_vehicle
from omnimate.vcan_sim.truth import Truth
from omnimate.vehicle.compiled import Record, record
from omnimate.vehicle.parameters import WHEELS, Limits, Truck

if TYPE_CHECKING:
    from omnimate.fleet.hall.faults import Fault
    from omnimate.vehicle.parameters import VehicleParameters
    from omnimate.vehicle.se2 import Array

TYPES = ("tug", "mule", "train")
# Nominal variation, relative to the size: standard deviations of the calibration; mean and standard deviation
# of the wear (a polyurethane tyre of 150 mm loses some 0.05 mm of diameter in a month); standard deviations
# from day to day, by load and temperature. Assumptions.
CALIBRATED_WHEEL, CALIBRATED_WHEELBASE = 1e-4, 1e-3
WEAR, WEAR_SCATTER = -1e-5, 3e-6  # [1/day]
DAILY_WHEEL, DAILY_WHEELBASE = 1e-5, 1e-4
_WHEEL_NAMES: tuple[str, ...] = WHEELS


@dataclass(frozen=True, slots=True)
class HallRobot:
    """A robot of the hall.

    `wheels`, `(4,)`, and `wheelbases`, `(2,)`, are ratios of true sizes on day 0 to nominal ones, less 1;
    wear is the change of the wheels' ratios [1/day], `(4,)`.
    """

    vehicle: VehicleParameters
    wheels: Array
    wheelbases: Array
    wear: Array
    faults: tuple[Fault, ...]
    seed: int

    def truth_on(self, day: int, lap: int) -> tuple[Truth, Record]:
        """Return the robot's true parameters in a lap of a day, and a record `(1,)` of `WheelFaults`."""
        daily = np.random.default_rng((self.seed, day))
        wheels = self.wheels + day * self.wear + DAILY_WHEEL * daily.normal(size=4)
        wheelbases = self.wheelbases + DAILY_WHEELBASE * daily.normal(size=2)
        wheel_faults, biases = record(WheelFaults), {"joint_a": 0.0, "joint_b": 0.0}
        for fault in self.faults:
            size = fault.at(day)
            if fault.kind == "wheelbase":
                wheelbases["ab".index(fault.component)] += size
            elif fault.kind == "joint_bias":
                biases[fault.component] += size
            elif fault.kind == "wheel_diameter":
                wheels[_WHEEL_NAMES.index(fault.component)] += size
            else:
                field = "amplitude" if fault.kind == "wheel_eccentricity" else "backlash"
                wheel_faults[field][0, _WHEEL_NAMES.index(fault.component)] = size
        true = self.vehicle
        for number, (name, truck) in enumerate(self.vehicle.trucks.items()):
            left, right = 1.0 + wheels[2 * number : 2 * number + 2]
            changed = Truck(
                truck.wheelbase * (1.0 + wheelbases[number]),
                truck.wheel_diameter_left * left,
                truck.wheel_diameter_right * right,
            )
            true = true.with_truck(name, changed)
        seed = int(np.random.default_rng((self.seed, day, lap)).integers(2**31))
        return Truth(true, effects=linkage_biases(**biases), seed=seed), wheel_faults


def draw_robot(
    kind: str, number: int, seed: int, sync_period: float = 0.015, faults: tuple[Fault, ...] = ()
) -> HallRobot:
    """Return a random robot.

    Its type is one of `TYPES`; its number is a part of its name and of its seed; `seed` is the hall's. The
    period of SYNC on its bus is in s.
    """
    chance = np.random.default_rng((seed, number))
    nominal = _nominal_vehicle(kind)
    bus = replace(nominal.bus, sync_period=sync_period)
    vehicle = replace(nominal, name=f"{kind}-{number:04d}", bus=bus)
    return HallRobot(
        vehicle,
        CALIBRATED_WHEEL * chance.normal(size=4),
        CALIBRATED_WHEELBASE * chance.normal(size=2),
        WEAR + WEAR_SCATTER * chance.normal(size=4),
        faults,
        int(chance.integers(2**31)),
    )


def _nominal_vehicle(kind: str) -> VehicleParameters:
    """Return the nominal parameters of a type: `tug` and `mule` have one truck, `train` has two."""
    if kind == "train":
        return reference_vehicle()
    robot = replace(reference_single(), limits=Limits(speed=0.8, acceleration=0.5))
    return robot if kind == "tug" else robot.with_truck("a", Truck(0.520, 0.200, 0.200))
