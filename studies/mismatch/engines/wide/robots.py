"""Robots of all sizes, encoders and clocks."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from studies.mismatch.engines.robots import Robot, encoders

if TYPE_CHECKING:
    from numpy.random import Generator

BASES = (0.12, 0.7)  # [m], from a toy to a field robot
RADII = (0.02, 0.17)  # [m]
COUNTS = (5e-6, 3e-4)  # [m] of way for one count of a wheel
JOINTS = (1024, 4096, 8192, 16384, 20000, 36000, 65536)  # counts per turn
METRES = (2e3, 1e5)  # counts per metre of the link
LENGTHS = (0.6, 1.5)  # [m] of the link
PERIODS = (0.01, 0.015, 0.02, 0.03, 0.05, 0.1)  # [s]
JITTER = 0.6  # [counts], the most
SERVOS = (0.2, 1.5), (0.6, 3.0)  # [m/s^2], [rad/s^2]


def wide_robot(chance: Generator, trucks: int) -> Robot:
    """Return a robot of any size, with a bus of random node ids."""
    radius, count = within(chance, RADII), within(chance, COUNTS)
    turn = round(2.0 * math.pi * radius / count)
    resolutions = turn, int(chance.choice(JOINTS)), round(within(chance, METRES))
    nodes = chance.permutation(np.arange(2, 60))
    length = within(chance, LENGTHS)
    return Robot(
        name=f"wide-{int(chance.integers(1000)):03d}",
        trucks=trucks,
        wheelbase=tuple(within(chance, BASES) for _ in range(trucks)),
        radius=(radius,) * (2 * trucks),
        length=length,
        period=float(chance.choice(PERIODS)),
        devices=encoders(chance, nodes, trucks, resolutions),
        jitter=float(chance.uniform(0.0, JITTER)),
        servo=(within(chance, SERVOS[0]), within(chance, SERVOS[1])),
        steady=2.0 / length,
    )


def within(chance: Generator, bounds: tuple[float, float]) -> float:
    """Return a number between two bounds, its logarithm uniform."""
    return math.exp(chance.uniform(math.log(bounds[0]), math.log(bounds[1])))
