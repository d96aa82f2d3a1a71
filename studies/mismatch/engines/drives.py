"""The drives: speeds and turn rates of truck a over time, lap by lap, with stops between the laps."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.random import Generator
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

STOP = 1.2  # [s] before and after each lap, for a measured pose

Leg = tuple[float, float, float]  # speed [m/s], turn rate [rad/s], duration [s]
Lap = tuple[str, list[Leg]]


def programme(chance: Generator, kind: str, laps: int) -> list[Lap]:
    """Return laps of a kind: squares, eights, slalom, or shuttle (with reversals)."""
    build = {"squares": _square, "eights": _eight, "slalom": _slalom, "shuttle": _shuttle}[kind]
    return [build(chance, number) for number in range(laps)]


def _speed(chance: Generator, number: int) -> float:
    return float((0.25, 0.45, 0.35)[number % 3] * chance.uniform(0.9, 1.1))


def _square(chance: Generator, number: int) -> Lap:
    speed, turn = _speed(chance, number), -1.0 if number % 2 == 0 else 1.0
    side, radius = 2.4, 0.6
    corner = (speed, turn * speed / radius, 0.5 * math.pi * radius / speed)
    return ("cw" if turn < 0 else "ccw"), [(speed, 0.0, side / speed), corner] * 4


def _eight(chance: Generator, number: int) -> Lap:
    speed, radius = _speed(chance, number), float(chance.uniform(0.7, 1.1))
    circle = 2.0 * math.pi * radius / speed
    return "none", [(speed, speed / radius, circle), (speed, -speed / radius, circle)]


def _slalom(chance: Generator, number: int) -> Lap:
    speed = _speed(chance, number)
    legs = []
    for bend in range(10):
        rate = (-1.0) ** bend * float(chance.uniform(0.2, 0.6))
        legs += [
            (speed, rate, float(chance.uniform(1.0, 2.0))),
            (speed, 0.0, float(chance.uniform(0.3, 1.0))),
        ]
    return "none", legs


def _shuttle(chance: Generator, number: int) -> Lap:
    speed = _speed(chance, number)
    legs = []
    for way in range(6):
        sign = 1.0 if way % 2 == 0 else -1.0
        legs += [(sign * speed, 0.0, float(chance.uniform(2.0, 3.5))), (0.0, 0.0, 0.4)]
        legs += [(0.0, float(chance.choice([-0.5, 0.5])), float(chance.uniform(0.5, 1.2))), (0.0, 0.0, 0.3)]
    return "none", legs


def commands(
    laps: list[Lap], period: float, servo: tuple[float, float]
) -> tuple[Array, list[tuple[str, int, int]]]:
    """Return the commands of a drive with limited acceleration.

    Args:
        laps: Laps, each as its direction and its legs.
        period: Sample period [s].
        servo: Most acceleration [m/s^2] and turn acceleration [rad/s^2].

    Returns:
        Speeds [m/s] and turn rates [rad/s], shape `(N, 2)`, and laps as (direction, first row, last row).
    """
    wanted: list[tuple[float, float]] = [(0.0, 0.0)] * round(STOP / period)
    spans = []
    for direction, legs in laps:
        first = len(wanted)
        for speed, rate, duration in legs:
            wanted += [(speed, rate)] * round(duration / period)
        wanted += [(0.0, 0.0)] * round(STOP / period)
        spans.append((direction, first, len(wanted) - 1))
        wanted += [(0.0, 0.0)] * round(STOP / period)
    target = np.array(wanted)
    driven = np.zeros_like(target)
    most = np.array(servo) * period
    for step in range(1, len(target)):
        driven[step] = driven[step - 1] + np.clip(target[step] - driven[step - 1], -most, most)
    return driven, spans
