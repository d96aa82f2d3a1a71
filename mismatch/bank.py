"""What a mismatch may depend on when it is none of the library's effects: a bank of plain curves.

Each component gets a group of columns: its error as a smooth curve of time, heading, speed, place, the
joints' angles and the like, with no physics in it. A group stands for "unknown, on this component": it
fits anything smooth, and pays for that with Occam's factor for every column that it has.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np

from mismatch.terms import Term
from mismatch.windows import pushed

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from mismatch.model import Columns
    from mismatch.regression import Regression
    from mismatch.windows import Windows
    from vehicle.se2 import Array

PER_METRE = 2e-3  # way lost per metre rolled, one standard deviation of a curve's coefficient
ANGLE = 3e-3  # [rad] of a joint's or a heading's error
UNLIKELY = -2.0  # log odds of one curve of something unknown against one effect of the library
LENGTH = 1e-3  # [m] of the link's or a position's error


@dataclass(frozen=True, slots=True)
class Curve:
    """One column of the bank.

    Attributes:
        component: on which the error is.
        quantity: on which it depends.
        channel: which of the component's errors: "way", "side", "turn" or "reading".
    """

    component: str
    quantity: str
    channel: str


def quantities(windows: Windows) -> dict[str, list[Array]]:
    """Return curves `(N - 1,)` of order one over each quantity that an error may depend on."""
    signals = windows.signals
    block, path = signals.block, signals.path
    count = len(block)
    phase = np.linspace(0.0, np.pi, count)
    lead = path[1:, 0]
    place = [_standard(lead[:, 0]), _standard(lead[:, 1])]
    curves = {
        "time": [np.cos(order * phase) for order in (1, 2, 3, 4)],
        "heading": [wave(order * lead[:, 2]) for order in (1, 2) for wave in (np.cos, np.sin)],
        "place": [*place, place[0] * place[1], place[0] ** 2, place[1] ** 2],
        "speed": [_standard(np.abs(block.speed[:, :2]).mean(axis=1))],
        "acceleration": [_standard(block.acceleration[:, :2].mean(axis=1))],
        "curvature": [_standard(block.twist[:, 0, 2] / block.period)],
    }
    if signals.reading.shape[1]:
        for number, joint in enumerate(("joint_a", "joint_b")):
            angle = block.reading[:, number]
            curves[f"{joint} angle"] = [_standard(angle), _standard(angle**2), np.sin(2.0 * angle)]
        curves["link length"] = [_standard(block.reading[:, 2])]
    return curves


def _standard(values: Array) -> Array:
    """Return values less their mean, in units of their deviation; zeros where they are constant."""
    away = values - values.mean()
    deviation = float(away.std())
    return away / deviation if deviation > 1e-9 else np.zeros_like(away)


def bank(windows: Windows) -> Iterator[tuple[Curve, Columns]]:
    """Yield every curve with its column: inputs `(M, 3 T)` and measurements `(M + 1, R)`."""
    curves = quantities(windows)
    for number, wheel in enumerate(windows.signals.recording.vehicle.wheels):
        angle = windows.signals.block.angle[:, number]
        curves[f"wheel angle of {wheel}"] = [
            wave(order * angle) for order in (1, 2) for wave in (np.cos, np.sin)
        ]
    for component, channel, build in _errors(windows):
        for quantity, values in curves.items():
            for value in values:
                yield Curve(component, quantity, channel), build(value)


def add_bank(regression: Regression) -> tuple[list[Term], list[slice]]:
    """Add the bank's columns; return a term "unknown" for each component and quantity, and where it is."""
    curves: list[Curve] = []
    columns: list[list[Columns]] = []
    for windows in regression.windows:
        pairs = sorted(bank(windows), key=lambda pair: (pair[0].component, pair[0].quantity))
        curves = [curve for curve, _ in pairs]
        columns.append([column for _, column in pairs])
    first = regression.extend(columns).start
    terms, places = [], []
    for key, group in groupby(range(len(curves)), lambda at: (curves[at].component, curves[at].quantity)):
        own = list(group)
        terms.append(Term("unknown", key[0], (), {"quantity": key[1]}, UNLIKELY, positive=False))
        places.append(slice(first + own[0], first + own[-1] + 1))
    return terms, places


def _errors(windows: Windows) -> list[tuple[str, str, Callable[[Array], Columns]]]:
    """Return every error that a robot may have: component, channel, and what a curve of it does."""
    signals = windows.signals
    wheels = {wheel: (number,) for number, wheel in enumerate(signals.recording.vehicle.wheels)}
    found: list[tuple[str, str, Callable[[Array], Columns]]] = []
    both = {"left": (0, 2), "right": (1, 3)} if len(wheels) == 4 else {}
    for name, numbers in {**wheels, **both}.items():
        found.append((name, "way", partial(_way, windows, numbers)))
    for number, truck in enumerate(signals.trucks):
        found.append((truck, "side", partial(_side, windows, number)))
    if windows.linkage:
        for row, name in enumerate(("joint_a", "joint_b", "link")):
            found.append((name, "reading", partial(_reading, windows, (row,))))
    if signals.poses is not None:
        for axis in range(3):
            rows = tuple(windows.linkage + 3 * truck + axis for truck in range(len(signals.trucks)))
            found.append(("poses", "reading", partial(_reading, windows, rows)))
    return found


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
