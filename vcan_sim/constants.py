"""The records of the plant, from a true robot, its nominal `vehicle.toml` and a floor."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omnimate.vcan_sim.biases import split_biases
from omnimate.vcan_sim.records import Constants, Obstacle
from omnimate.vehicle.compiled import Record, layout, record
from omnimate.vehicle.parameters import WHEELS

if TYPE_CHECKING:
    from omnimate.vcan_sim.floor import Bump
    from omnimate.vcan_sim.truth import Truth
    from omnimate.vehicle.parameters import Encoder, VehicleParameters


def constants_of(truth: Truth, vehicle: VehicleParameters) -> Record:
    """Return the constants record `(1,)` of a true robot whose encoders are those of `vehicle`."""
    constants = record(Constants)
    robot = constants[0]
    (*joint_biases, link_bias), _ = split_biases(truth.effects)
    robot["trucks"], robot["seed"], robot["roughness"] = (
        len(truth.vehicle.trucks),
        truth.seed,
        truth.floor.roughness,
    )
    robot["wheelbase"] = truth.vehicle.trucks["a"].wheelbase
    if truth.vehicle.linkage is not None and vehicle.linkage is not None:
        robot["wheelbase"][1] = truth.vehicle.trucks["b"].wheelbase
        robot["link_zero"] = vehicle.linkage.length - link_bias
        robot["shortest"] = truth.vehicle.linkage.length - truth.stroke
        robot["longest"] = truth.vehicle.linkage.length + truth.stroke
    robot["joint_bias"] = joint_biases
    for number, wheel in enumerate(truth.vehicle.wheels):
        robot["radius"][number] = 0.5 * truth.vehicle.wheel_diameter(wheel)
        robot["servo"][number] = truth.servo / robot["radius"][number]
    generator = np.random.default_rng(truth.seed)
    for number, channel in enumerate(vehicle.expected_channels):
        encoder = vehicle.encoder(channel)
        robot["scale"][number] = 1.0 / encoder.scale
        robot["offset"][number] = _first_count(encoder, generator)
    return constants


def _first_count(encoder: Encoder, generator: np.random.Generator) -> float:
    """Return the counts at angle 0: random for a wheel, whose encoder has no zero; else its `zero`."""
    if encoder.channel in WHEELS:
        span = min(encoder.wrap_range, 2**32)
        return float(generator.uniform(-0.5, 0.5) * span) + (0.0 if encoder.signed else 0.5 * span)
    return float(encoder.zero)


def obstacles_of(bumps: tuple[Bump, ...], vehicle: VehicleParameters) -> Record:
    """Return the `Obstacle` records `(K,)`: one for each bump and each wheel that may cross it."""
    obstacles = []
    for bump in bumps:
        wheels = vehicle.wheels if bump.wheel is None else (bump.wheel,)
        for wheel in wheels:
            radius = 0.5 * vehicle.wheel_diameter(wheel)
            obstacle = np.zeros((), layout(Obstacle))
            obstacle["wheel"], obstacle["scheduled"] = vehicle.wheels.index(wheel), bump.wheel is not None
            obstacle["lap"] = -1 if bump.lap is None else bump.lap
            obstacle["after"], obstacle["size"] = bump.after, bump.size
            obstacle["x"], obstacle["y"] = bump.x, bump.y
            crossing = bump.crossing(radius)
            obstacle["lost"], obstacle["span"] = crossing.lost, crossing.rolled
            obstacles.append(obstacle)
    return np.array(obstacles, layout(Obstacle))
