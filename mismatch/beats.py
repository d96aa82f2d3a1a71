"""Beats: a pitch at which wheels lose or gain, along their way or from place to place on the floor.

What comes back at a pitch of the way is of the wheel or its drive; what comes back at a pitch of the floor,
like the joints between slabs, is met in another rhythm on every leg.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from omnimate.mismatch.bank import sides, unknown
from omnimate.mismatch.leftover import strengths
from omnimate.vehicle.se2 import transform

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from omnimate.mismatch.leftover import Leftover
    from omnimate.mismatch.model import Columns
    from omnimate.mismatch.regression import Regression
    from omnimate.mismatch.terms import Term
    from omnimate.mismatch.windows import Windows
    from omnimate.vehicle.se2 import Array

BEAT = 32.0  # chi-square of a beat and its overtones that the best of many pitches hardly reaches by chance
FLOOR = 45.0  # likewise on a floor, which has joints both ways
_PITCHES = 600
_FINEST = 0.2  # [m] of a pitch
_COARSEST = 3.0
_ORDERS = (1, 2, 3)
_NEAR = 9  # rates between one that can be told apart and the next
_GAIN, _WAVE = 1e-3, 3e-4  # of the way, and [m], one standard deviation


@dataclass(frozen=True, slots=True)
class _Along:
    """What a beat may go by: numbers [m] of each wheel at the windows' ends, for every recording.

    Attributes:
        name: in words.
        numbers: of each recording (D, M + 1, W), for D numbers that beat at one pitch together.
        extent: over which they run, all together [m].
        least: chi-square from which a pitch is worth comparing.
    """

    name: str
    numbers: list[Array]
    extent: float
    least: float

    def rates(self) -> Array:
        """Return the rates [1/m] that can be told apart."""
        step = max(0.5 / max(self.extent, _COARSEST), (1.0 / _FINEST) / _PITCHES)
        return np.arange(1.0 / _COARSEST, 1.0 / _FINEST, step)


def beats(regression: Regression, left: Leftover) -> Iterator[tuple[Term, list[list[Columns]]]]:
    """Propose pitches at which a wheel, or both wheels of one side, lose or gain, with their columns."""
    groups = list(sides(regression.windows[0]).items())
    for along in _alongs(regression):
        rates = along.rates()
        powers = _powers(regression, left, along, [numbers for _, numbers in groups], rates)
        for (component, numbers), power in zip(groups, powers, strict=True):
            whole = _with_overtones(power, rates)
            best = int(np.argmax(whole))
            if whole[best] > along.least:
                near = rates[best] + (rates[1] - rates[0]) * np.linspace(-0.5, 0.5, _NEAR)
                rate = float(near[np.argmax(_powers(regression, left, along, [numbers], near))])
                term = unknown(component, f"{along.name}, every {1.0 / rate:.2f} m")
                term = replace(term, plausibility=term.plausibility - math.log(len(rates)))
                columns = [
                    _columns(windows, own, numbers, rate)
                    for windows, own in zip(regression.windows, along.numbers, strict=True)
                ]
                yield term, columns


def _with_overtones(power: Array, rates: Array) -> Array:
    """Return the chi-square of each rate with those of its overtones: what comes at moments has many."""
    whole = power.copy()
    for order in _ORDERS[1:]:
        there = np.searchsorted(rates, order * rates - 0.5 * (rates[1] - rates[0]))
        known = there < len(rates)
        whole[known] += power[there[known]]
    return whole


def _alongs(regression: Regression) -> list[_Along]:
    """Return the way that the wheels have rolled, and where on the floor they are."""
    ways = [_ways(windows)[None] for windows in regression.windows]
    places = [_places(windows) for windows in regression.windows]
    rolled = sum(float(np.abs(own[0, -1]).max()) for own in ways)
    room = max(float(np.ptp(own, axis=1).max()) for own in places)
    return [_Along("the way", ways, rolled, BEAT), _Along("the place on the floor", places, room, FLOOR)]


def _ways(windows: Windows) -> Array:
    """Return the way (M + 1, W) that each wheel has rolled at the windows' ends [m]."""
    travel = windows.signals.block.travel
    return np.concatenate((np.zeros((1, travel.shape[1])), np.cumsum(travel, axis=0)))[windows.ends]


def _places(windows: Windows) -> Array:
    """Return x and y (2, M + 1, W) of each wheel on the floor at the windows' ends [m]."""
    path, base = windows.signals.path[windows.ends], windows.signals.block.wheelbase
    half = 0.5 * np.repeat(base, 2) * np.tile([1.0, -1.0], len(base))
    beside = np.stack([np.zeros_like(half), half], axis=-1)
    return np.moveaxis(transform(np.repeat(path, 2, axis=1), beside), -1, 0)


def _powers(
    regression: Regression,
    left: Leftover,
    along: _Along,
    groups: Sequence[tuple[int, ...]],
    rates: Array,
) -> Array:
    """Return the chi-square of every group at every rate, `(G, F)`."""
    depth = along.numbers[0].shape[0]
    wheels = len(regression.windows[0].signals.recording.vehicle.wheels)
    shape = (len(groups), len(rates), depth, 2)

    def build(number: int, windows: Windows, columns: range) -> Array:
        gained = np.zeros((len(windows.ends) - 1, wheels, len(columns)))
        for at, column in enumerate(columns):
            group, rate, axis, quarter = (int(one) for one in np.unravel_index(column, shape))
            for wheel in groups[group]:
                own = along.numbers[number][axis, :, wheel]
                gained[:, wheel, at] = _wave(own, float(rates[rate]), 0.5 * np.pi * quarter)
        return gained

    sigmas = strengths(regression, [left], build, math.prod(shape))[0]
    return np.asarray((sigmas.reshape(shape) ** 2).sum(axis=(2, 3)))


def _wave(number: Array, rate: float, phase: float) -> Array:
    """Return what is gained in each window (M,): a wave of a number, met alike in both directions."""
    return np.asarray(np.diff(np.cos(2.0 * np.pi * rate * number + phase)) * np.sign(np.diff(number)))


def _columns(windows: Windows, numbers: Array, wheels: tuple[int, ...], rate: float) -> list[Columns]:
    """Return columns of wheels that gain or lose a share of their way, and beat at a rate per metre."""
    lever, still = windows.lever[:, :, : windows.drift.shape[1]], np.zeros(windows.measured.shape)
    ways = np.diff(_ways(windows), axis=0)
    gains = [_GAIN * ways] + [
        _WAVE / order * np.stack([_wave(one, order * rate, phase) for one in own.T], axis=1)
        for own in numbers
        for order in _ORDERS
        for phase in (0.0, 0.5 * np.pi)
    ]
    picked = list(wheels)
    return [(-np.einsum("mw,mwi->mi", gain[:, picked], lever[:, picked]), still) for gain in gains]
