"""The robots of the papers, and what calibration has left on them."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Literal, get_args

import numpy as np

from omnimate.ipec.filter.prior import Prior
from omnimate.vcan_sim.biases import linkage_biases
from omnimate.vcan_sim.floor import Bump, Floor
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.truth import Truth, with_errors
from omnimate.vehicle.floor import CONCRETE_ROUGHNESS
from omnimate.vehicle.parameters import VehicleParameters
from omnimate.vehicle.sonar import Sonar

# The terms of the error budget; each can be left out alone, see `studies.papers.rows`.
Term = Literal["nothing", "sonar", "floor", "joint bias", "link bias", "wheels", "joint steps"]
TERMS: tuple[Term, ...] = get_args(Term)

# The linkage is known to 0.01 degrees at each joint, for IPEC drifts with their difference (C 5.2: 0.01
# degrees in 1 m make 0.2 degrees in 18 m), and to 0.3 mm in length (0.1 degrees a turn). UMBmark with 5 + 5
# runs knows the ratio of diameters to 1e-4 and the wheelbase to 1e-3; a day later the tyres have moved.
LEFT_BEHIND = Prior(1e-9, 2e-4, 1e-3, math.radians(0.01), 3e-4)

# The OmniMate of O 3 drove without wheel calibration: without IPEC its laps turned by 3.7 degrees too much on
# average without any bump, and r_cg was 205 mm. Wheels 8e-4 apart make 2.5 degrees in 18.5 m, a wheelbase
# off by 0.3 % makes 1.1 degrees in a turn; truck b errs otherwise. The linkage is calibrated as above.
UNCALIBRATED = Prior(1e-9, 1e-3, 3e-3, LEFT_BEHIND.joint, LEFT_BEHIND.link)


def clapper() -> VehicleParameters:
    """Return the CLAPPER: joints of 360/1024 degrees, 40 ms, C 6."""
    robot = with_joints(reference_vehicle(), 1024)
    return replace(robot, name="clapper", bus=replace(robot.bus, sync_period=0.040))


def omnimate() -> VehicleParameters:
    """Return the OmniMate of O 3: 15 ms."""
    return reference_vehicle()


def fine() -> VehicleParameters:
    """Return a robot whose joints and link have a very fine resolution."""
    robot = with_joints(reference_vehicle(), 2**24)
    encoders = tuple(
        replace(encoder, counts_per_metre=1e8, zero=50_000_000) if encoder.channel == "link" else encoder
        for encoder in robot.encoders
    )
    return replace(robot, encoders=encoders)


def with_joints(robot: VehicleParameters, counts: int) -> VehicleParameters:
    """Return a robot whose joint encoders have `counts` counts in a turn."""
    encoders = tuple(
        replace(encoder, counts_per_turn=float(counts), range=counts, zero=counts // 2)
        if encoder.channel.startswith("joint")
        else encoder
        for encoder in robot.encoders
    )
    return replace(robot, encoders=encoders)


def without_steps(robot: VehicleParameters, without: Term) -> VehicleParameters:
    """Return the robot, with very fine joint encoders where `without` leaves out their steps."""
    return with_joints(robot, 2**22) if without == "joint steps" else robot


def calibrated_truth(
    robot: VehicleParameters, bumps: tuple[Bump, ...], seed: int, without: Term = "nothing"
) -> Truth:
    """Return a robot on concrete whose errors are drawn from those that remain after a calibration."""
    chance = np.random.default_rng(1000 + seed)
    base_a, base_b = (1.0 + LEFT_BEHIND.wheelbase * chance.normal(size=2)).tolist()
    ratio_a, ratio_b = (1.0 + LEFT_BEHIND.ratio * chance.normal(size=2)).tolist()
    real = with_errors(robot, {"a": base_a, "b": base_b}, {"a": ratio_a, "b": ratio_b})
    return _truth(robot if without == "wheels" else real, chance, bumps, seed, without)


def uncalibrated_truth(
    robot: VehicleParameters, bumps: tuple[Bump, ...], seed: int, without: Term = "nothing"
) -> Truth:
    """Return the OmniMate of O 3 on concrete, whose linkage alone was calibrated."""
    real = with_errors(robot, {"a": 0.997, "b": 1.002}, {"a": 1.0008, "b": 0.9995})
    chance = np.random.default_rng(1000 + seed)
    return _truth(robot if without == "wheels" else real, chance, bumps, seed, without)


def _truth(
    real: VehicleParameters, chance: np.random.Generator, bumps: tuple[Bump, ...], seed: int, without: Term
) -> Truth:
    joint_a, joint_b = (LEFT_BEHIND.joint * chance.normal(size=2)).tolist()
    link = float(LEFT_BEHIND.link * chance.normal())
    if without == "joint bias":
        joint_a = joint_b = 0.0
    return Truth(
        real,
        effects=linkage_biases(joint_a, joint_b, 0.0 if without == "link bias" else link),
        floor=Floor(0.0 if without == "floor" else CONCRETE_ROUGHNESS, bumps),
        sonar=Sonar(sigma=0.0),  # the calibrator's noise is added to its fixes, see `estimates.measured`
        seed=seed,
    )
