"""From a true robot, its owner's file and a floor to the records that the plant works on."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from vcan_sim.records import Constants, Obstacle
from vehicle.compiled import Record, layout, record
from vehicle.parameters import WHEELS

if TYPE_CHECKING:
    from vcan_sim.bumps import Bump
    from vcan_sim.truth import Truth
    from vehicle.parameters import Encoder, VehicleParameters


def constants_of(truth: Truth, vehicle: VehicleParameters) -> Record:
    """Return the constants record `(1,)` of a true robot whose encoders are those of `vehicle`."""
    constants = record(Constants)
    own = constants[0]
    own["trucks"], own["seed"], own["roughness"] = (
        len(truth.vehicle.trucks),
        truth.seed,
        truth.floor.roughness,
    )
    own["wheelbase"] = truth.vehicle.trucks["a"].wheelbase
    if truth.vehicle.linkage is not None and vehicle.linkage is not None:
        own["wheelbase"][1] = truth.vehicle.trucks["b"].wheelbase
        own["link_zero"] = vehicle.linkage.length - truth.link_bias
        own["shortest"] = truth.vehicle.linkage.length - truth.stroke
        own["longest"] = truth.vehicle.linkage.length + truth.stroke
    own["joint_bias"] = truth.joint_bias
    for number, wheel in enumerate(truth.vehicle.wheels):
        own["radius"][number] = 0.5 * truth.vehicle.wheel_diameter(wheel)
        own["servo"][number] = truth.servo / own["radius"][number]
    chance = np.random.default_rng(truth.seed)
    for number, channel in enumerate(vehicle.expected_channels):
        encoder = vehicle.encoder(channel)
        own["scale"][number] = 1.0 / encoder.scale
        own["offset"][number] = _first_count(encoder, chance)
    return constants


def _first_count(encoder: Encoder, chance: np.random.Generator) -> float:
    """Return the counts at angle 0: anywhere for a wheel, which knows no zero."""
    if encoder.channel in WHEELS:
        span = min(encoder.wrap_range, 2**32)
        return float(chance.uniform(-0.5, 0.5) * span) + (0.0 if encoder.signed else 0.5 * span)
    return float(encoder.zero)


def obstacles_of(bumps: tuple[Bump, ...], vehicle: VehicleParameters) -> Record:
    """Return one record per bump and wheel that may meet it, `(K,)`."""
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
            obstacle["lost"], obstacle["span"] = bump.lost(radius), bump.span(radius)
            obstacles.append(obstacle)
    return np.array(obstacles, layout(Obstacle))
