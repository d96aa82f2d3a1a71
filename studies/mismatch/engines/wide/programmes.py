"""Drives of all kinds: what robots do for a calibration, and what they do all day."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from studies.mismatch.engines.wide.robots import within

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.random import Generator

    from studies.mismatch.engines.drives import Lap, Leg

SPEEDS = (0.12, 0.6)  # [m/s]
DURATIONS = (60.0, 240.0)  # [s] of a drive, and no more samples than MOST
MOST = 12000
REST: Leg = (0.0, 0.0, 0.8)


def wide_programme(chance: Generator, kind: str, trucks: int, period: float) -> list[Lap]:
    """Return laps of a kind, a key of `PROGRAMMES`, until a duration is reached.

    Args:
        chance: Source of what is drawn.
        kind: Kind of the drive.
        trucks: Number of trucks; one alone may turn on the spot.
        period: Sample period [s].
    """
    speed, duration = within(chance, SPEEDS), min(within(chance, DURATIONS), MOST * period)
    lap_of, driven = PROGRAMMES[kind](chance, speed, trucks), 0.0
    laps: list[Lap] = []
    while driven < duration or len(laps) < 2:
        laps.append(lap_of(len(laps)))
        driven += sum(leg[2] for leg in laps[-1][1])
        if driven > 2.0 * duration:
            break
    return laps


def _squares(chance: Generator, speed: float, trucks: int) -> Callable[[int], Lap]:
    side, radius, spot = within(chance, (1.0, 4.0)), within(chance, (0.4, 1.0)), chance.random() < 0.5
    rate = within(chance, (0.3, 1.0))
    in_turn = chance.random() < 0.5  # cw and ccw in turn, or first some of one

    def lap(number: int) -> Lap:
        turn = 1.0 if (number % 2 if in_turn else number % 6 > 2) else -1.0
        if spot and trucks == 1:
            corner: list[Leg] = [REST, (0.0, turn * rate, 0.5 * math.pi / rate), REST]
        else:
            corner = [(speed, turn * speed / radius, 0.5 * math.pi * radius / speed)]
        legs = [(speed, 0.0, side / speed), *corner] * 4
        return ("ccw" if turn > 0.0 else "cw"), legs

    return lap


def _straights(chance: Generator, speed: float, _trucks: int) -> Callable[[int], Lap]:
    length = within(chance, (3.0, 12.0))
    back = chance.random() < 0.5

    def lap(number: int) -> Lap:
        sign = -1.0 if back and number % 2 else 1.0
        return "none", [(sign * speed, 0.0, length / speed), REST]

    return lap


def _shuttles(chance: Generator, speed: float, _trucks: int) -> Callable[[int], Lap]:
    length, times = within(chance, (0.8, 3.0)), int(chance.integers(1, 5))
    return lambda _number: (
        "none",
        [(speed, 0.0, length / speed), REST, (-speed, 0.0, length / speed), REST] * times,
    )


def _eights(chance: Generator, speed: float, _trucks: int) -> Callable[[int], Lap]:
    radius = within(chance, (0.5, 2.0))
    circle, rate = 2.0 * math.pi * radius / speed, speed / radius
    return lambda _number: ("none", [(speed, rate, circle), (speed, -rate, circle)])


def _free(chance: Generator, speed: float, trucks: int) -> Callable[[int], Lap]:
    def leg() -> Leg:
        own, time = speed * float(chance.uniform(0.3, 1.3)), float(chance.uniform(1.0, 6.0))
        bend = float(chance.uniform(-0.8, 0.8)) if chance.random() < 0.6 else 0.0
        if trucks == 1 and chance.random() < 0.15:
            return 0.0, 1.5 * bend, time
        return own, bend * min(1.0, own / 0.3), time

    def lap(_number: int) -> Lap:
        return "none", [REST if chance.random() < 0.15 else leg() for _ in range(12)]

    return lap


def _docking(chance: Generator, speed: float, trucks: int) -> Callable[[int], Lap]:
    run, creep = within(chance, (0.8, 3.0)), within(chance, (0.04, 0.1))

    def lap(_number: int) -> Lap:
        turn = float(chance.uniform(0.2, 0.7)) * (1.0 if chance.random() < 0.5 else -1.0)
        aside: Leg = (0.0, turn, 1.0) if trucks == 1 else (0.5 * speed, 0.7 * turn, 2.0)
        approach: list[Leg] = [(speed, 0.0, run / speed), (creep, 0.0, 0.2 / creep), REST, REST]
        return "none", [*approach, (-0.6 * speed, 0.0, 0.6 * run / speed), REST, aside, REST]

    return lap


PROGRAMMES: dict[str, Callable[[Generator, float, int], Callable[[int], Lap]]] = {
    "squares": _squares,
    "straights": _straights,
    "shuttles": _shuttles,
    "eights": _eights,
    "free": _free,
    "docking": _docking,
}
