"""The drives of C 6 and O 3."""

from __future__ import annotations

from typing import Literal

import numpy as np

from omnimate.motion.paths import out_and_back, rounded_rectangle
from omnimate.vcan_sim.floor import Bump, bumps_under
from omnimate.vcan_sim.simulate import simulate
from omnimate.vehicle.parameters import WHEELS, Channel
from omnimate.vehicle.recording import Direction, Recording
from studies.papers.robots import Term, calibrated_truth, clapper, omnimate, uncalibrated_truth, without_steps

Turning = Literal["cw", "ccw"]
_LINK = 1.0  # [m] the truck behind meets the same cable so much later
_CABLE = 0.009  # [m] O 3


def straight(seed: int, bumps: int, without: Term = "nothing") -> Recording:
    """Return C 6.1: 18 m out and back in reverse, 3 runs.

    Args:
        seed: Seed of the robot's errors and of the floor.
        bumps: Number of bumps that each truck's right wheel meets on the way back, truck b first.
        without: Cause of the error budget that is left out.
    """
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
    robot = without_steps(omnimate(), without)
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
    return next(wheel for wheel in WHEELS if wheel == f"{truck}.{side}")
