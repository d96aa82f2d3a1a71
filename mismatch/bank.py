"""What a mismatch may depend on when it is none of the library's effects: a bank of plain curves.

Each component's error is a smooth curve of one quantity: time, heading, speed, place, a joint's angle and
the like, with no physics in it. Such a group of columns stands for "unknown, on this component, depending
on this": it fits anything smooth, and pays for that with Occam's factor for every column that it has.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np

from omnimate.mismatch.terms import ANSWERED, FOLLOWED, Term
from omnimate.mismatch.windows import pushed

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from omnimate.mismatch.model import Columns
    from omnimate.mismatch.regression import Regression
    from omnimate.mismatch.windows import Windows
    from omnimate.vehicle.se2 import Array

PER_METRE = 2e-3  # of the way rolled, one standard deviation of a curve's coefficient
PER_TURN = 5e-3  # of the angle turned, likewise
ANGLE = 3e-3  # [rad] of a joint's or a heading's error
MARK = 5e-3  # [m] of the markers' place on a truck
LENGTH = 1e-3  # [m] of the link's or a position's error
UNLIKELY = -3.5  # log odds of something unknown against one effect of the library

ALWAYS = "nothing but the way driven"
RATE = "its rate of change"
MOTION = "its direction of motion"
MARKED = "where on the trucks the markers are"

Curves = dict[str, list["Array"]]


@dataclass(frozen=True, slots=True)
class Error:
    """An error that a robot may have.

    Attributes:
        component: on which it is.
        build: what a curve `(N - 1,)` of it does, as a column.
        own: quantities that only this error may depend on.
        level: what it depends on where it is the same everywhere; empty where that would be two named
            effects of one size.
    """

    component: str
    build: Callable[[Array], Columns]
    own: Curves
    level: str = ALWAYS


def add_bank(regression: Regression) -> tuple[list[Term], list[slice]]:
    """Add the bank's columns; return a term "unknown" for each component and quantity, and where it is."""
    keys: list[tuple[str, str]] = []
    columns: list[list[Columns]] = []
    for windows in regression.windows:
        pairs = sorted(bank(windows), key=lambda pair: pair[0])
        keys = [key for key, _ in pairs]
        columns.append([column for _, column in pairs])
    first = regression.extend(columns).start
    terms, places = [], []
    for (component, quantity), group in groupby(range(len(keys)), lambda at: keys[at]):
        numbers = list(group)
        terms.append(unknown(component, quantity))
        places.append(slice(first + numbers[0], first + numbers[-1] + 1))
    return terms, places


def unknown(component: str, quantity: str, moments: tuple[float, ...] = ()) -> Term:
    """Return the term of an unknown error that depends on a quantity, or acts at moments [s]."""
    fixed = {"quantity": quantity, "moments": moments}
    answered = ANSWERED if component in FOLLOWED and quantity in (RATE, MOTION) else 0.0
    return Term("unknown", component, (), fixed, UNLIKELY - answered, positive=False)


def bank(windows: Windows) -> Iterator[tuple[tuple[str, str], Columns]]:
    """Yield columns, each with its component and quantity; a constant belongs to every quantity."""
    shared = quantities(windows)
    level = np.ones(len(windows.signals.block))
    for error in errors(windows):
        curves = {**shared, **error.own}
        constant = [error.build(level)] if error.level else []
        yield from (((error.component, error.level), column) for column in constant)
        if error.level == MARKED:
            continue  # they do not wander
        for quantity, values in curves.items():
            for column in (
                *constant,
                *(error.build(value if constant else value - value.mean()) for value in values),
            ):
                yield (error.component, quantity), column


def quantities(windows: Windows) -> Curves:
    """Return curves `(N - 1,)` of order one over each quantity that any error may depend on."""
    signals = windows.signals
    block, lead = signals.block, signals.path[1:, 0]
    phase = np.linspace(0.0, np.pi, len(block))
    place = [_standard(lead[:, 0]), _standard(lead[:, 1])]
    curves = {
        "time": [*(np.cos(order * phase) for order in (1, 2, 3, 4)), *_warming(phase)],
        "heading": [wave(order * lead[:, 2]) for order in (1, 2) for wave in (np.cos, np.sin)],
        "place": [*place, place[0] * place[1], place[0] ** 2, place[1] ** 2],
        "speed": [_standard(np.abs(block.speed[:, :2]).mean(axis=1))],
        "acceleration": [_standard(block.acceleration[:, :2].mean(axis=1))],
        "turn rate": [_standard(block.twist[:, 0, 2] / block.period)],
    }
    if signals.reading.shape[1]:
        for number, joint in enumerate(("joint_a", "joint_b")):
            angle = block.reading[:, number]
            waves = [wave(order * angle) for order in (1, 2, 3) for wave in (np.cos, np.sin)]
            curves[f"angle of {joint}"] = [_standard(angle), _standard(angle**2), *waves]
        curves["link length"] = [_standard(block.reading[:, 2])]
    return curves


def _warming(phase: Array) -> list[Array]:
    """Return what approaches its end within a quarter and within a tenth of the drive."""
    return [_standard(np.exp(-phase / (np.pi * part))) for part in (0.25, 0.1)]


def _standard(values: Array) -> Array:
    """Return values less their mean, in units of their deviation; zeros where they are constant."""
    away = values - values.mean()
    deviation = float(away.std())
    return away / deviation if deviation > 1e-9 else np.zeros_like(away)


def errors(windows: Windows) -> list[Error]:
    """Return every error that a robot may have."""
    signals = windows.signals
    block = signals.block
    found = []
    for component, numbers in sides(windows).items():
        angle = block.angle[:, numbers[0]]
        waves = [wave(order * angle) for order in (1, 2, 3) for wave in (np.cos, np.sin)]
        level = ALWAYS if len(numbers) == 1 else ""
        found.append(Error(component, partial(_way, windows, numbers), {"angle of its wheel": waves}, level))
    for number, truck in enumerate(signals.trucks):
        found.append(Error(truck, partial(_side, windows, number), {}))
        found.append(Error(truck, partial(_turn, windows, number), {}, "turning, nothing else"))
    for row, name in enumerate(("joint_a", "joint_b", "link")[: windows.linkage]):
        rate = np.diff(block.reading[:, row], prepend=block.reading[0, row]) / block.period
        own = {RATE: [_standard(rate)], MOTION: [np.sign(rate)]}
        found.append(Error(name, partial(_reading, windows, (row,)), own))
    if signals.poses is not None:
        found += [Error("poses", partial(_seen, windows, axis), {}, MARKED) for axis in range(2)]
        for axis in range(3):
            rows = tuple(windows.linkage + 3 * truck + axis for truck in range(len(signals.trucks)))
            found.append(Error("poses", partial(_reading, windows, rows), {}))
    return found


def sides(windows: Windows) -> dict[str, tuple[int, ...]]:
    """Return the wheels, and both left or right wheels together, with their columns."""
    wheels = windows.signals.recording.vehicle.wheels
    alone: dict[str, tuple[int, ...]] = {str(wheel): (number,) for number, wheel in enumerate(wheels)}
    return {**alone, "left": (0, 2), "right": (1, 3)} if len(wheels) == 4 else alone


def _way(windows: Windows, wheels: tuple[int, ...], value: Array) -> Columns:
    """Return the column of wheels that roll by a curve more per metre."""
    block = windows.signals.block
    twist = np.zeros_like(block.twist)
    for wheel in wheels:
        gained = PER_METRE * value * block.travel[:, wheel]
        truck, sign = wheel // 2, (-1.0, 1.0)[wheel % 2]
        twist[:, truck, 0] += 0.5 * gained
        twist[:, truck, 2] += sign * gained / block.wheelbase[truck]
    return _pushed(windows, twist)


def _side(windows: Windows, truck: int, value: Array) -> Columns:
    """Return the column of a truck that creeps sideways by a curve per metre."""
    block = windows.signals.block
    twist = np.zeros_like(block.twist)
    twist[:, truck, 1] = PER_METRE * value * np.abs(block.twist[:, truck, 0])
    return _pushed(windows, twist)


def _turn(windows: Windows, truck: int, value: Array) -> Columns:
    """Return the column of a truck that turns by a curve more per angle."""
    block = windows.signals.block
    twist = np.zeros_like(block.twist)
    twist[:, truck, 2] = PER_TURN * value * block.twist[:, truck, 2]
    return _pushed(windows, twist)


def _pushed(windows: Windows, twist: Array) -> Columns:
    return -pushed(windows.signals, windows.ends, twist), np.zeros(windows.measured.shape)


def _reading(windows: Windows, rows: tuple[int, ...], value: Array) -> Columns:
    """Return the column of sensors that read a curve too much."""
    measured = np.zeros(windows.measured.shape)
    at = np.concatenate((value[:1], value))[windows.ends]
    for row in rows:
        angle = row < 2 if row < windows.linkage else (row - windows.linkage) % 3 == 2
        measured[:, row] = (ANGLE if angle else LENGTH) * at
    return np.zeros(windows.drift.shape), measured


def _seen(windows: Windows, axis: int, value: Array) -> Columns:
    """Return the column of poses of a point that is a curve's first value ahead (0) or left (1)."""
    measured = np.zeros(windows.measured.shape)
    for truck in range(len(windows.signals.trucks)):
        first, heading = windows.linkage + 3 * truck, windows.signals.path[windows.ends, truck, 2]
        ahead = np.stack([np.cos(heading), np.sin(heading)], axis=1)
        along = ahead if axis == 0 else np.stack([-ahead[:, 1], ahead[:, 0]], axis=1)
        measured[:, first : first + 2] = MARK * value[0] * along
    return np.zeros(windows.drift.shape), measured
