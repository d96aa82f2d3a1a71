"""Looking for stretches of time in which a wheel slipped."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omnimate.mismatch.leftover import EVENT, strengths, travelled, wheels_of
from omnimate.mismatch.signals import WINDOW
from omnimate.mismatch.terms import term

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.mismatch.leftover import Leftover
    from omnimate.mismatch.regression import Regression
    from omnimate.mismatch.terms import Term
    from omnimate.mismatch.windows import Windows
    from omnimate.vehicle.se2 import Array

_SHORTEST = 1.5  # [s] of a patch
_PATCHES = 200  # of the shortest kind in a recording, however long that is

Slip = tuple[tuple[int, float, float], int]  # recording, start and end [s], and wheel


def patches(regression: Regression, lefts: Sequence[Leftover]) -> list[Term]:
    """Propose stretches of time in which wheels slipped, of any length, at any place, for each leftover."""
    spans = [
        (number, start, start + length)
        for number, windows in enumerate(regression.windows)
        for start, length in _stretches(windows.time[0], windows.time[-1])
    ]
    wheels = wheels_of(regression)
    everywhere = [(span, number) for span in spans for number in range(len(wheels))]
    slips: list[Slip] = []
    for left, sigmas in zip(lefts, _strengths(regression, lefts, everywhere), strict=True):
        strong = [
            [row * len(wheels) + number for row in np.argsort(-own)[:2] if own[row] > EVENT]
            for number, own in enumerate(sigmas.reshape(len(spans), len(wheels)).T)
        ]
        slips += [everywhere[at] for own in strong for at in own]
        slips += _sharpened(regression, left, [everywhere[own[0]] for own in strong if own])
    return [
        term("slip_patch", wheels[number], len(spans), intervals=((float(start), float(end)),))
        for (_, start, end), number in slips
    ]


def _sharpened(regression: Regression, left: Leftover, slips: Sequence[Slip]) -> list[Slip]:
    """Return slips whose starts and ends were moved to where they are strongest, in ever smaller steps."""
    step = max((end - start for (_, start, end), _ in slips), default=0.0) / 4.0
    best = list(slips)
    while step > 0.5 * WINDOW:
        moves = [(one * step, other * step) for one in (-1, 0, 1) for other in (-1, 0, 1)]
        tried = [
            ((owner, start + first, max(end + last, start + first + step)), number)
            for (owner, start, end), number in best
            for first, last in moves
        ]
        sigmas = _strengths(regression, [left], tried).reshape(len(best), len(moves))
        best = [tried[len(moves) * row + int(np.argmax(own))] for row, own in enumerate(sigmas)]
        step /= 2.0
    return best


def _strengths(regression: Regression, lefts: Sequence[Leftover], slips: Sequence[Slip]) -> Array:
    """Return by how many sigma each slip would be estimated in each leftover, `(L, S)`."""

    def build(number: int, windows: Windows, columns: range) -> Array:
        way = travelled(windows)
        middle = 0.5 * (windows.time[1:] + windows.time[:-1])
        gained = np.zeros((*way.shape, len(columns)))
        for at, column in enumerate(columns):
            (owner, start, end), wheel = slips[column]
            if owner == number:
                inside = slice(*np.searchsorted(middle, (start, end)))
                gained[inside, wheel, at] = -way[inside, wheel]
        return gained

    return strengths(regression, lefts, build, len(slips))


def _stretches(start: float, end: float) -> list[tuple[float, float]]:
    """Return starts and lengths that overlap by half, each length twice the one before."""
    found, length = [], max(_SHORTEST, (end - start) / _PATCHES)
    while length < 0.6 * (end - start):
        found += [(float(at), length) for at in np.arange(start, end - 0.5 * length, 0.5 * length)]
        length *= 2.0
    return found
