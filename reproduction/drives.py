"""The drives of C 6 and O 3, and what each estimator makes of them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np

from ipec.corrector import correct
from ipec.estimate import estimate
from ipec.smoother import smooth
from motion.paths import out_and_back, rounded_rectangle
from reproduction.linkage_numbers import lap_errors
from reproduction.robots import (
    LEFT_BEHIND,
    UNCALIBRATED,
    calibrated_truth,
    clapper,
    omnimate,
    uncalibrated_truth,
)
from vcan_sim.bumps import bumps_under
from vcan_sim.simulate import simulate
from vehicle.recording import Poses

if TYPE_CHECKING:
    from ipec.filter import Prior
    from vcan_sim.bumps import Bump
    from vehicle.parameters import Channel
    from vehicle.recording import Direction, Recording
    from vehicle.se2 import Array

Estimator = Literal["plain", "CLAPPER", "OmniMate", "filter", "smoother"]
ESTIMATORS: tuple[Estimator, ...] = get_args(Estimator)
Turning = Literal["cw", "ccw"]

CLAPPER_SONAR = np.array([0.002, 0.002, math.radians(0.25)])  # C 6
OMNIMATE_SONAR = np.array([0.003, 0.003, math.radians(0.2)])  # O 3: 0.3 % of about a metre, 0.2 degrees


def straight(seed: int, bumps: int) -> Recording:
    """Return C 6.1: 18 m out and back in reverse, 3 runs.

    Args:
        seed: of robot and floor.
        bumps: that each truck's right wheel meets on the way back.
    """
    placed: tuple[Bump, ...] = ()
    wheels: tuple[Channel, ...] = ("a.right", "b.right")
    for lap in range(3) if bumps else ():
        for wheel in wheels:
            placed += bumps_under(wheel, bumps, 18.5, 35.5, lap=lap)
    robot = clapper()
    program = out_and_back(18.0, 3, speed=0.45, link_length=1.0)
    return simulate(robot, calibrated_truth(robot, placed, seed), program)


def rectangle(seed: int, direction: Turning, laps: int, bumps: int) -> Recording:
    """Return C 6.2: laps of 7 x 4 m; bumps under the right wheels of both trucks in each of them."""
    placed: tuple[Bump, ...] = ()
    wheels: tuple[Channel, ...] = ("a.right", "b.right")
    for lap in range(laps) if bumps else ():
        for wheel in wheels:
            placed += bumps_under(wheel, bumps, 1.0, 19.0, lap=lap)
    robot = clapper()
    directions: list[Direction] = [direction] * laps
    program = rounded_rectangle(7.0, 4.0, directions, tolerance=0.2, speed=0.45)
    return simulate(robot, calibrated_truth(robot, placed, seed), program)


def laps(seed: int, direction: Turning) -> Recording:
    """Return O 3: laps 1-5 without bumps, 6-10 with 20 cables of 9 mm under the wheels named there."""
    inside, outside = ("left", "right") if direction == "ccw" else ("right", "left")
    plan: list[tuple[str, int, int]] = [(f"a.{inside}", 20, 5), (f"a.{outside}", 20, 6)]
    plan += [(f"{truck}.{inside}", 10, 7) for truck in "ab"]
    plan += [(f"{truck}.{outside}", 10, 8) for truck in "ab"]
    plan += [(f"{truck}.{side}", 5, 9) for truck in "ab" for side in ("left", "right")]
    bumps: tuple[Bump, ...] = ()
    for wheel, count, lap in plan:
        bumps += bumps_under(wheel, count, 1.0, 15.0, lap=lap, height=0.009)  # type: ignore[arg-type]  # channels
    robot = omnimate()
    directions: list[Direction] = [direction] * 10
    return simulate(robot, uncalibrated_truth(robot, bumps, seed), rounded_rectangle(6.0, 3.25, directions))


def return_errors(
    recording: Recording, sonar: Array, seed: int, estimators: tuple[Estimator, ...] = ESTIMATORS
) -> dict[Estimator, Array]:
    """Return the return errors `(L, 3)` of each estimator, measured with a sonar of sigma `(3,)`.

    Each estimate is compared lap by lap, from the fix before to the fix after it; no estimator is given more.
    """
    seen = measured(recording, sonar, seed)
    prior = UNCALIBRATED if recording.vehicle.name == "omnimate" else LEFT_BEHIND
    return {name: lap_errors(recording, path_of(recording, name, seen, prior), seen) for name in estimators}


def path_of(recording: Recording, name: Estimator, seen: Poses, prior: Prior) -> Array:
    """Return the path `(N, 3)` of truck a by an estimator, from the first fix on."""
    start = seen.pose[0]
    if name == "plain":
        return correct(recording, start, method="plain").pose_a
    if name == "CLAPPER":
        return correct(recording, start, method="clapper").pose_a
    if name == "OmniMate":
        return correct(recording, start, method="omnimate").pose_a
    run = estimate if name == "filter" else smooth
    return run(recording, start, seen.sigma[0], prior=prior).pose_a


def measured(recording: Recording, sonar: Array, seed: int) -> Poses:
    """Return the exact fixes of truck a with the noise of a sonar of sigma `(3,)`."""
    assert recording.poses is not None
    fixes = recording.poses.of("a")
    noise = np.random.default_rng(seed).normal(size=fixes.pose.shape) * sonar
    return Poses(fixes.time, fixes.body, fixes.pose + noise, np.tile(sonar, (len(fixes.time), 1)))


def sizes(errors: Array) -> tuple[Array, Array]:
    """Return distance [mm] and |heading| [degrees], `(L,)` each, of return errors `(L, 3)`."""
    return 1e3 * np.hypot(errors[:, 0], errors[:, 1]), np.degrees(np.abs(errors[:, 2]))
