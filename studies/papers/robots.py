"""The robots of the papers, what calibration has left on them, and the drives of C 6 and O 3."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Literal, get_args

import numpy as np

from omnimate.ipec.filter.prior import Prior
from omnimate.motion.paths import out_and_back, rounded_rectangle
from omnimate.vcan_sim.biases import linkage_biases
from omnimate.vcan_sim.floor import Bump, Floor, bumps_under
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth, with_errors
from omnimate.vehicle.floor import CONCRETE_ROUGHNESS
from omnimate.vehicle.parameters import WHEELS, Channel, VehicleParameters
from omnimate.vehicle.recording import Direction, Recording
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
        sonar=Sonar(sigma=0.0),  # the calibrator's noise is added to its fixes, see `protocols.measured`
        seed=seed,
    )


Turning = Literal["cw", "ccw"]
_LINK = 1.0  # [m] the truck behind meets the same cable so much later
_CABLE = 0.009  # [m] O 3


def straight(seed: int, bumps: int, without: Term = "nothing") -> Recording:
    """Return C 6.1: 3 runs of 18 m out and back in reverse, right wheels meeting bumps on the way back."""
    placed: tuple[Bump, ...] = ()
    for lap in range(3) if bumps else ():
        placed += bumps_under("a.right", bumps, 18.5, 35.5, lap=lap)
        placed += bumps_under("b.right", bumps, 18.5 - _LINK, 35.5 - _LINK, lap=lap)
    robot = without_steps(clapper(), without)
    program = out_and_back(18.0, 3, speed=0.45, link_length=1.0)
    return simulate(robot, calibrated_truth(robot, placed, seed, without), program)


def rectangle(seed: int, direction: Turning, laps: int, bumps: int, without: Term = "nothing") -> Recording:
    """Return C 6.2: laps of 7 x 4 m from the corner and back to it.

    Bumps lie under the right wheels of both trucks in the first half of the laps, under the left wheels in
    the other half.
    """
    placed: tuple[Bump, ...] = ()
    for lap in range(laps) if bumps else ():
        side = "right" if lap < laps // 2 else "left"
        front, behind = _channel("a", side), _channel("b", side)
        placed += bumps_under(front, bumps, 1.0, 19.0, lap=lap)
        placed += bumps_under(behind, bumps, 1.0 + _LINK, 19.0 + _LINK, lap=lap)
    robot = without_steps(clapper(), without)
    directions: list[Direction] = [direction] * laps
    program = rounded_rectangle(7.0, 4.0, directions, tolerance=0.2, speed=0.45, first=6.0)
    return simulate(robot, calibrated_truth(robot, placed, seed, without), program)


def laps(seed: int, direction: Turning, without: Term = "nothing") -> Recording:
    """Return O 3: laps 1-5 without bumps, 6-10 with 20 cables of 9 mm under the wheels named there.

    The figure that shows where a lap starts is lost. O 3.2 has the left and the bottom wall beside and
    behind the robot when it starts cw, the one at the centre and the top one when it starts ccw; and O
    Table I has 205 mm at 3.7 degrees, hence a mean lever of 3.2 m, where the middle of a short side of
    6 x 3.25 m gives 3.0 m and that of a long side 1.6 m. So it starts in the middle of a short side. That
    brings r_cg near the print and takes the worst position of plain odometry over bumps away from it.
    """
    inside, outside = ("left", "right") if direction == "ccw" else ("right", "left")
    plan: list[tuple[Channel, int, int]] = [
        (_channel("a", inside), 20, 5),
        (_channel("a", outside), 20, 6),
        *((_channel(truck, inside), 10, 7) for truck in "ab"),
        *((_channel(truck, outside), 10, 8) for truck in "ab"),
    ]
    bumps: tuple[Bump, ...] = ()
    for wheel, count, lap in plan:
        bumps += bumps_under(wheel, count, 1.0, 15.0, lap=lap, height=_CABLE)
    robot = without_steps(reference_vehicle(), without)
    truth = uncalibrated_truth(robot, bumps + _at_random(2 * seed + (direction == "cw")), seed, without)
    directions: list[Direction] = [direction] * 10
    return simulate(robot, truth, rounded_rectangle(3.25, 6.0, directions))


def _at_random(seed: int) -> tuple[Bump, ...]:
    """Return the bumps of lap 10 of O 3: 20 bumps, each under a random wheel and at a random place."""
    chance = np.random.default_rng(2000 + seed)
    wheels = chance.integers(len(WHEELS), size=20).tolist()
    places = chance.uniform(1.0, 15.0, size=20).tolist()
    return tuple(
        Bump(_CABLE, wheel=WHEELS[wheel], after=place, lap=9)
        for wheel, place in zip(wheels, places, strict=True)
    )


def _channel(truck: str, side: str) -> Channel:
    return WHEELS[2 * "ab".index(truck) + (side == "right")]
