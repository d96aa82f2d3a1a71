"""Programmes: speeds and turn rates of truck a over time, lap by lap, with stops between the laps."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.random import Generator

from studies.mismatch.engines.vocabulary import Array
from studies.mismatch.engines.wide.robots import within

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


def eight(speed: float, radius: float) -> list[Leg]:
    """Return a circle of a radius [m] to the left and one to the right."""
    circle, rate = 2.0 * math.pi * radius / speed, speed / radius
    return [(speed, rate, circle), (speed, -rate, circle)]


def _eight(chance: Generator, number: int) -> Lap:
    speed, radius = _speed(chance, number), float(chance.uniform(0.7, 1.1))
    return "none", eight(speed, radius)


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
    """Return speeds [m/s] and turn rates [rad/s], `(N, 2)`, and laps as (direction, first row, last row).

    `servo` is the most acceleration [m/s^2] and turn acceleration [rad/s^2].
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


ALIGN = 1.5  # [1/s], gain with which truck b turns into the link; it lags behind in turns


def wheel_ways(
    tracks: Sequence[float] | Array,
    speed: float,
    rate: float,
    linkage: Sequence[float] | Array,
    gains: tuple[float, float, float],
) -> Array:
    """Return the speeds of all wheels [m/s], `(2 T,)`, for a speed [m/s] and turn rate [rad/s] of truck a.

    Truck b follows the linkage: joint_a [rad], joint_b [rad] and the link's length [m]; one truck has none.
    Gains are that with which truck a, driving backwards, turns into the link [1/m], that with which truck b
    keeps the link's length [1/s], and this length at rest [m].
    """
    motion = [(speed, rate)]
    if len(tracks) == 2:
        (joint_a, joint_b, length), (into, hold, rest) = linkage, gains
        motion = [(speed, rate + into * min(speed, 0.0) * joint_a)]
        motion += [(speed * math.cos(joint_a) + hold * (length - rest), -ALIGN * joint_b)]
    return np.array(
        [
            forward + side * track * turn
            for (forward, turn), track in zip(motion, tracks, strict=True)
            for side in (-0.5, 0.5)
        ]
    )


SPEEDS = (0.12, 0.6)  # [m/s]
DURATIONS = (60.0, 240.0)  # [s] of a drive, and no more samples than MOST
MOST = 12000
REST: Leg = (0.0, 0.0, 0.8)


def wide_programme(chance: Generator, kind: str, trucks: int, period: float) -> list[Lap]:
    """Return laps of a kind, a key of `PROGRAMMES`, until a duration is reached."""
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
    return lambda _number: ("none", eight(speed, radius))


def _free(chance: Generator, speed: float, trucks: int) -> Callable[[int], Lap]:
    def leg() -> Leg:
        leg_speed, time = speed * float(chance.uniform(0.3, 1.3)), float(chance.uniform(1.0, 6.0))
        bend = float(chance.uniform(-0.8, 0.8)) if chance.random() < 0.6 else 0.0
        if trucks == 1 and chance.random() < 0.15:
            return 0.0, 1.5 * bend, time
        return leg_speed, bend * min(1.0, leg_speed / 0.3), time

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
