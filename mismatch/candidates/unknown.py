"""What a mismatch may depend on when it is none of the library's effects: smooth curves, and free pushes.

Each component's error is a smooth curve of one quantity: time, heading, speed, place, a joint's angle and the
like, with no physics in it. Such a group of columns stands for "unknown, on this component, depending on
this": it fits anything smooth, and pays for that with Occam's factor for every column that it has.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from omnimate.effects.block import LINKAGE
from omnimate.mismatch.candidates.quantities import shared_quantities
from omnimate.mismatch.candidates.regression import slices_of
from omnimate.mismatch.candidates.terms import UNKNOWN, Term, Unknown, turns
from omnimate.mismatch.recording.response import misread_columns, moved_columns
from omnimate.mismatch.recording.windows import pushed_by_curves

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterator, Sequence

    from numpy.typing import NDArray

    from omnimate.mismatch.candidates.quantities import Curves
    from omnimate.mismatch.candidates.regression import Regression
    from omnimate.mismatch.recording.response import Columns
    from omnimate.mismatch.recording.windows import Windows
    from omnimate.vehicle.se2 import Array

PER_METRE = 2e-3  # of the way rolled, one standard deviation of a curve's coefficient
PER_TURN = 5e-3  # of the angle turned, likewise
ANGLE = 3e-3  # [rad] of a joint's or a heading's error
LENGTH = 1e-3  # [m] of the link's or a position's error
# [1/m] by which a floor repeats itself along the axes of a recording: from tiles of 0.25 m to a room of five
# metres, so close to each other that one of them stays in phase over that room
REPEATS = np.arange(0.2, 4.05, 0.1)
FIELD = "place and heading on a floor that repeats every {:.2f} m"
FLOOR = "place on a floor that repeats every {:.2f} m"


# Component, what the error acts on, and quantity; its columns among those of the error.
Group = tuple[tuple[str, str, str], list[int]]


@dataclass(frozen=True, slots=True)
class Error:
    """An error that a robot may have."""

    component: str  # component that has it
    acts_on: str  # quantity that it changes, as in an effect `law`; empty where no law can be written down
    build: Callable[[Array], Columns]  # function from curves `(N - 1, B)` of the error to their columns
    constant_is_calibrated: bool = False  # if constant, it is a wrong number of vehicle.toml, with a name


class UnknownErrors(NamedTuple):
    """Candidates for errors without a name, one for each component and quantity."""

    terms: list[Term]  # the candidates
    widths: list[int]  # number of columns of each
    # all whitened columns, in the same order, `(V, C)`; single precision, as there are thousands
    columns: NDArray[np.float32]
    quantities: dict[str, int]  # of the drive, each with its number of columns in `curves`
    curves: Array  # their curves at the instant of each row, then their changes before it, `(V, Q)`


def unknown_errors(regression: Regression) -> UnknownErrors:
    """Return a candidate for each component and quantity.

    Quantities that the drive hardly excites are noise, and no curve may depend on them.
    """
    signals = [windows.signals for windows in regression.windows]
    curves, turned = shared_quantities(signals), turns(signals)
    pairs = zip(regression.windows, curves, strict=True)
    errors_of_recordings = list(zip(*(_columns(*pair, turned=turned) for pair in pairs), strict=True))
    groups = [group for (of_error, _), *_ in errors_of_recordings for group in of_error]
    columns = np.empty((len(regression.owner), sum(len(order) for _, order in groups)), np.float32)
    first = 0
    for of_recordings in errors_of_recordings:  # all at once in double precision would take much memory
        order = [column for _, of_group in of_recordings[0][0] for column in of_group]
        white = regression.whitened([build() for _, build in of_recordings])
        columns[:, first : first + len(order)] = white[:, order]
        first += len(order)
    odds = Unknown.prior.log_odds - math.log(len(groups) / len({group[:2] for group, _ in groups}))
    terms = [
        Term(UNKNOWN, component, (), {"quantity": quantity, "acts_on": acts_on}, odds, positive=False)
        for (component, acts_on, quantity), _ in groups
    ]
    return UnknownErrors(
        terms,
        [len(order) for _, order in groups],
        columns,
        {quantity: 2 * len(values) for quantity, values in curves[0].items()},
        _curves_of_rows(regression, curves),
    )


def raw_columns(regression: Regression, numbers: Collection[int]) -> dict[int, list[Columns]]:
    """Return of some of all unknown errors, by number, each recording's columns before they are whitened."""
    signals = [windows.signals for windows in regression.windows]
    turned = turns(signals)
    pairs = zip(regression.windows, shared_quantities(signals), strict=True)
    raw, first = {}, 0
    for of_recordings in zip(*(_columns(*pair, turned=turned) for pair in pairs), strict=True):
        groups, _ = of_recordings[0]
        wanted = {number: order for number, (_, order) in enumerate(groups, first) if number in numbers}
        first += len(groups)
        columns = [build() for _, build in of_recordings] if wanted else []
        for number, order in wanted.items():
            raw[number] = [(inputs[:, :, order], measured[:, :, order]) for inputs, measured in columns]
    return raw


def _curves_of_rows(regression: Regression, shared: Sequence[Curves]) -> Array:
    """Return each quantity's curves at the instant of each row, then their changes before it, `(V, Q)`."""
    at_ends = [
        np.hstack([windows.at_ends(np.stack(values, axis=1)) for values in curves.values()])
        for windows, curves in zip(regression.windows, shared, strict=True)
    ]
    now, before, earlier = (
        regression.of_rows([_earlier(values, count) for values in at_ends]) for count in range(3)
    )
    of_poses = (regression.channel >= regression.windows[0].linkage)[:, None]
    now, before = np.where(of_poses, before, now), np.where(of_poses, earlier, before)
    changes = now - before
    places = slices_of(map(len, shared[0].values()))
    return np.hstack([part[:, place] for place in places for part in (now, changes)])


def _earlier(at_ends: Array, count: int) -> Array:
    """Return values at the ends of windows (K, B), a number of windows earlier.

    A robot may steer by its poses: what it does from one on answers the noise of this pose, and would seem to
    predict it.
    """
    return at_ends[np.maximum(np.arange(len(at_ends)) - count, 0)]


def _columns(
    windows: Windows, shared: Curves, *, turned: bool
) -> Iterator[tuple[list[Group], Callable[[], Columns]]]:
    """Yield of each error its groups, which share a constant, and a function that builds all columns.

    That is one error at a time, as all take much memory. Errors per turn are left out where the drive does
    not turn.
    """
    level = np.ones(len(windows.signals.block))
    curves = np.stack([level, *(curve for values in shared.values() for curve in values)], axis=1)
    places = dict(zip(shared, slices_of(map(len, shared.values()), 1), strict=True))
    for error in errors(windows):
        if error.acts_on == "turn" and not turned:
            continue
        constant = [] if error.constant_is_calibrated else [0]
        yield (
            [
                ((error.component, error.acts_on, quantity), [*constant, *range(place.start, place.stop)])
                for quantity, place in places.items()
            ],
            partial(error.build, curves),
        )
    for component, wheels in _rolling(windows):
        yield _repeating(component, FLOOR, 4), partial(_patterns, windows, wheels)
    for number, truck in enumerate(windows.signals.trucks if turned else ()):
        yield _repeating(truck, FIELD, 8), partial(_pulls, windows, number)


def _repeating(component: str, floor: str, width: int) -> list[Group]:
    """Return the groups of a component's errors on floors that repeat themselves."""
    return [
        ((component, "", floor.format(1.0 / repeats)), list(range(width * number, width * (number + 1))))
        for number, repeats in enumerate(REPEATS)
    ]


def errors(windows: Windows) -> list[Error]:
    """Return every error that a robot may have."""
    signals = windows.signals
    possible = [
        Error(
            component,
            "travel" if len(wheels) == 1 else "",
            partial(_way, windows, wheels),
            constant_is_calibrated=True,
        )
        for component, wheels in _rolling(windows)
    ]
    block = signals.block
    for number, truck in enumerate(signals.trucks):
        distance, yaw = PER_METRE * np.abs(block.twist[:, number, 0]), PER_TURN * block.twist[:, number, 2]
        turn = partial(_moves, windows, number, 2, yaw)
        possible.append(Error(truck, "creep", partial(_moves, windows, number, 1, distance)))
        possible.append(Error(truck, "turn", turn, constant_is_calibrated=True))
        possible.append(
            Error(truck, "yaw", partial(_moves, windows, number, 2, distance / block.wheelbase[number]))
        )
    for row, name in enumerate(LINKAGE[: windows.linkage]):
        possible.append(Error(name, "reading", partial(_reading, windows, (row,))))
    if signals.poses is not None:
        for axis in range(3):
            rows = tuple(windows.linkage + 3 * truck + axis for truck in range(len(signals.trucks)))
            possible.append(Error("poses", "", partial(_reading, windows, rows)))
    return possible


def _rolling(windows: Windows) -> list[tuple[str, tuple[int, ...]]]:
    """Return the components that roll alike, wheels and sides of two trucks, with their wheels."""
    wheels = windows.signals.wheels
    rolling: list[tuple[str, tuple[int, ...]]] = [
        (str(wheel), (number,)) for number, wheel in enumerate(wheels)
    ]
    return [*rolling, ("left", (0, 2)), ("right", (1, 3))] if len(wheels) == 4 else rolling


def _patterns(windows: Windows, wheels: tuple[int, ...]) -> Columns:
    """Return the columns of wheels that roll over floors that repeat themselves along both axes."""
    block = windows.signals.block
    parts = []
    for wheel in wheels:
        truck = wheel // 2
        heading = block.heading[:, truck]
        aside = (0.5, -0.5)[wheel % 2] * block.wheelbase[truck]
        place = block.place[:, truck] + aside * np.stack([-np.sin(heading), np.cos(heading)], axis=1)
        parts.append(_way(windows, (wheel,), _waves_at(place).reshape(len(block), -1)))
    return np.sum([inputs for inputs, _ in parts], axis=0), parts[0][1]


def _pulls(windows: Windows, truck: int) -> Columns:
    """Return the columns of a truck that floors which repeat themselves pull to either side.

    A pull acts along either axis: on a floor with waves a truck creeps downhill.
    """
    block = windows.signals.block
    heading = block.heading[:, truck]
    waves = _waves_at(block.place[:, truck]).reshape(len(block), len(REPEATS), 1, 4)
    left = np.stack([-np.sin(heading), np.cos(heading)], axis=1).reshape(len(block), 1, 2, 1)
    creep = PER_METRE * np.abs(block.twist[:, truck, 0])
    return _moves(windows, truck, 1, creep, (waves * left).reshape(len(block), -1))


def _waves_at(place: Array) -> Array:
    """Return cosines and sines of what repeats itself along both axes, of places (K, 2): `(K, R, 4)`."""
    waves = np.empty((len(place), len(REPEATS), 2), complex)
    waves[:, 0] = np.exp(2j * np.pi * REPEATS[0] * place)
    waves[:, 1:] = np.exp(2j * np.pi * (REPEATS[1] - REPEATS[0]) * place)[:, None]
    curves = np.multiply.accumulate(waves, axis=1).view(float)
    curves -= curves.mean(axis=0)  # a wave that is longer than the way would be a constant
    return curves


def sizes_of(component: str, acts_on: str) -> float:
    """Return the standard deviation of a curve's coefficient, in the unit of a law of a quantity."""
    if acts_on == "reading":
        return LENGTH if component == "link" else ANGLE
    return PER_TURN if acts_on == "turn" else PER_METRE


def wheels_roll(windows: Windows, wheels: tuple[int, ...], curves: Array) -> Columns:
    """Return the columns of wheels that roll by curves `(N - 1, B)` more per metre."""
    block = windows.signals.block
    twist = np.zeros_like(block.twist)
    for wheel in wheels:
        gained = block.travel[:, wheel]
        truck, sign = wheel // 2, (-1.0, 1.0)[wheel % 2]
        twist[:, truck, 0] += 0.5 * gained
        twist[:, truck, 2] += sign * gained / block.wheelbase[truck]
    return _pushed(windows, twist, curves)


def _way(windows: Windows, wheels: tuple[int, ...], curves: Array) -> Columns:
    return wheels_roll(windows, wheels, PER_METRE * curves)


def _moves(windows: Windows, truck: int, axis: int, size: Array, curves: Array) -> Columns:
    """Return the columns of a truck that moves along an axis of its twist by curves of a size `(N - 1,)`."""
    twist = np.zeros_like(windows.signals.block.twist)
    twist[:, truck, axis] = size
    return _pushed(windows, twist, curves)


def _pushed(windows: Windows, twist: Array, curves: Array) -> Columns:
    return moved_columns(windows, -pushed_by_curves(windows.signals, windows.ends, twist, curves))


def _reading(windows: Windows, rows: tuple[int, ...], curves: Array) -> Columns:
    """Return the columns of sensors that read curves too much."""
    measured = np.zeros((*windows.measured.shape, curves.shape[1]))
    at = windows.at_ends(curves)
    if rows[0] >= windows.linkage:
        at = _earlier(at, 1)
    for row in rows:
        angle = row < 2 if row < windows.linkage else (row - windows.linkage) % 3 == 2
        measured[:, row] = (ANGLE if angle else LENGTH) * at
    return misread_columns(windows, measured)
