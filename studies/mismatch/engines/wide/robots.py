"""Robots of all sizes, encoders and clocks, and measurements of all kinds."""

from __future__ import annotations

import math

import numpy as np
from numpy.random import Generator

from studies.mismatch.engines.writing import Measuring, Robot, encoders

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


PLACES, HEADINGS = (5e-4, 0.01), (5e-4, 0.01)  # [m], [rad] that are stated
POSE_PERIODS = (0.02, 0.05, 0.1, 0.2, 1.0)  # [s]
WRONG = 3.0  # factor by which what is stated may be wrong, both ways
LEVER = 0.01  # [m] by which markers sit off the centre, at most
LATE = (0.01, 0.1)  # [s]


def wide_measuring(chance: Generator, trucks: int, *, dense: bool = False) -> Measuring | None:
    """Return how a drive's poses are measured; a robot with one truck is measured somehow."""
    kind = (
        chance.choice(["none", "stops", "dense", "dense"])
        if trucks == 2
        else chance.choice(["stops", "dense"])
    )
    if kind == "none" and not dense:
        return None
    place, heading = within(chance, PLACES), within(chance, HEADINGS)
    honest, centred, prompt = chance.random(3) < (0.5, 0.75, 0.8)
    angle = float(chance.uniform(-math.pi, math.pi))
    off = 0.0 if centred else float(chance.uniform(0.002, LEVER))
    return Measuring(
        sigma=(place, place, heading),
        period=float(chance.choice(POSE_PERIODS)) if dense or kind == "dense" else 0.0,
        both=trucks == 2 and bool(chance.random() < 0.5),
        noise=1.0 if honest else within(chance, (1.0 / WRONG, WRONG)),
        lever=(off * math.cos(angle), off * math.sin(angle)),
        delay=0.0 if prompt or kind == "stops" else within(chance, LATE),
        outliers=0.0 if chance.random() < 0.8 else 0.01,
    )


def secondary(measuring: Measuring | None) -> list[dict[str, str]]:
    """Return what is true of the poses beside any fault: naming it is right, missing it no mistake."""
    if measuring is None:
        return []
    true = []
    if measuring.delay:
        true += ["latency", "clock_drift", "unknown"]
    if measuring.lever != (0.0, 0.0) or measuring.outliers or measuring.noise > 1.0:
        true += ["unknown"]
    return [{"effect": effect, "component": "poses"} for effect in dict.fromkeys(true)]
