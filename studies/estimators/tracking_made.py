"""The cases of `tracking` in the project's own simulator, with the true pose at every sample.

They are the simple ones: a single thing is wrong, and all else scatters as on an ordinary floor.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from omnimate.effects.floor_slope import FloorSlope
from omnimate.effects.lateral_slip import LateralSlip
from omnimate.effects.law import Law
from omnimate.effects.radius_step import RadiusStep
from omnimate.effects.traction_slip import TractionSlip
from omnimate.effects.wheel_eccentricity import WheelEccentricity
from omnimate.effects.wheel_misalignment import WheelMisalignment
from omnimate.motion.paths import rounded_rectangle
from omnimate.motion.runner import Runner
from omnimate.motion.stepping import step
from omnimate.vcan_sim.biases import linkage_biases
from omnimate.vcan_sim.bumps import bumps_under
from omnimate.vcan_sim.floor import Floor
from omnimate.vcan_sim.onboard import odometry_of, see
from omnimate.vcan_sim.plant import Plant
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.truth import Truth, with_errors
from omnimate.vehicle.recording import Poses, Recording
from studies.estimators.tracking_worlds import SEED

if TYPE_CHECKING:
    from collections.abc import Iterator

    from omnimate.effects.effect import Effect

ROBOT = reference_vehicle()
PROGRAM = rounded_rectangle(6.0, 3.25, ["ccw", "cw"])  # O 3
JITTER = math.radians(0.3)  # of joints that scatter
# Pushes of 10 mm to the side within 50 mm of the way, in m/m over the way of a truck.
PUSHES = (5.0, 12.0, 20.0, 27.0, 33.0)
STRIKE = 0.05  # [m]


def made(seed: int = SEED) -> Iterator[tuple[str, Recording]]:
    """Yield each case and its recording."""
    for number, (what, truth) in enumerate(_truths().items()):
        recording = _drive(replace(truth, seed=seed + number))
        yield what, _jittered(recording, seed) if what == "joint noise 0.3 degrees" else recording


def _truths() -> dict[str, Truth]:
    inside = bumps_under("a.left", 20, 1.0, 16.0, height=0.009)
    both = bumps_under("a.left", 10, 1.0, 15.0) + bumps_under("b.right", 10, 1.0, 15.0)
    plain = Truth(ROBOT, floor=Floor())

    def sizes(base_a: float = 1.0, base_b: float = 1.0, ratio_a: float = 1.0, ratio_b: float = 1.0) -> Truth:
        return Truth(with_errors(ROBOT, {"a": base_a, "b": base_b}, {"a": ratio_a, "b": ratio_b}))

    def acting(*effects: Effect) -> Truth:
        return replace(plain, effects=effects)

    return {
        "healthy": plain,
        "diameter a +0.3 %": sizes(ratio_a=1.003),
        "diameter b +1 %": sizes(ratio_b=1.01),
        "diameters a and b +-0.3 %": sizes(ratio_a=1.003, ratio_b=1.0 / 1.003),
        "wheelbase a -1 %": sizes(0.99),
        "wheelbases off by 3 %": sizes(1.03, 0.97),
        "as data sheets: U Fig. 11": sizes(336.17 / 340.0, 340.0 / 336.17, 1.00084, 1.0 / 1.00084),
        "bumps inside a": replace(plain, floor=Floor(bumps=inside)),
        "bumps a and b": replace(plain, floor=Floor(bumps=both)),
        "joint a 0.5 degrees": acting(*linkage_biases(joint_a=math.radians(0.5))),
        "joint b 0.5 degrees": acting(*linkage_biases(joint_b=math.radians(0.5))),
        "link 5 mm": acting(*linkage_biases(link=0.005)),
        "joint noise 0.3 degrees": replace(sizes(ratio_a=1.002), floor=Floor(bumps=inside)),
        "axle b turned 0.3 degrees": acting(WheelMisalignment("b", math.radians(0.3))),
        "eccentric wheel 0.5 mm": acting(WheelEccentricity("a.left", 5e-4, 0.3)),
        "puncture": acting(RadiusStep("b.left", 0.995, 60.0)),
        "floor sloping": acting(FloorSlope("a", 0.004, 0.7), FloorSlope("b", 0.004, 0.7)),
        "lateral slip": acting(LateralSlip("a", 0.05), LateralSlip("b", 0.02)),
        "traction slip": acting(TractionSlip("a", 0.1)),
        "sideways pushes of 10 mm": acting(_pushes()),
    }


def _pushes() -> Law:
    """Return pushes of truck a to the left and to the right in turn, each of 10 mm."""
    knots, ordinates = [0.0], [0.0]
    for number, place in enumerate(PUSHES):
        strength = (-1.0) ** number * 0.01 / STRIKE
        knots += [place - 1e-3, place, place + STRIKE, place + STRIKE + 1e-3]
        ordinates += [0.0, strength, strength, 0.0]
    return Law("a", "creep", over="way", knots=tuple(knots), ordinates=tuple(ordinates))


def _drive(truth: Truth) -> Recording:
    """Return the recording of the program, driven from odometry alone, with the true poses of truck a."""
    plant, runner, odometry = Plant(truth, ROBOT), Runner(PROGRAM, ROBOT), odometry_of(ROBOT)[0]
    command, period = np.zeros(4), ROBOT.bus.sync_period
    counts, poses = [], []
    lap = None
    while not runner.done:
        counts.append(plant.state["counts"][0].copy())
        poses.append(plant.pose("a"))
        pose, link = see(odometry, counts[-1])
        step(runner.rows, runner.settings, runner.state, pose, link, command)
        plant.advance(command, period)
        if runner.lap != lap:
            lap = runner.lap
            plant.begin_lap(lap)
    time = period * np.arange(len(counts), dtype=np.float64)
    table = np.array(counts)
    judge = Poses(time, np.full(len(time), "a"), np.array(poses), np.full((len(time), 3), 1e-6))
    return Recording(ROBOT, time, table, np.ones(table.shape, np.bool_), poses=judge, source="simulation")


def _jittered(recording: Recording, seed: int) -> Recording:
    """Return a recording whose joints scatter from sample to sample."""
    counts = recording.counts.copy()
    for number, channel in enumerate(ROBOT.channels):
        if channel.startswith("joint"):
            jitter = np.random.default_rng([seed, number]).normal(size=len(counts)) * JITTER
            counts[:, number] += np.rint(jitter / ROBOT.encoder(channel).scale).astype(np.int64)
    return replace(recording, counts=counts)
