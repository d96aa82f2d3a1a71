"""What no effect explains and no smooth curve: pushes at single moments, and beats along the way.

They are proposed as terms "unknown" wherever a leftover shows them, and have to stand against all others.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from omnimate.mismatch.bank import sides, unknown
from omnimate.mismatch.beats import beats
from omnimate.mismatch.leftover import EVENT, apart, lost_way, quiet, shocks, windows_in_all
from omnimate.mismatch.signals import WINDOW
from omnimate.mismatch.terms import MOMENTS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.mismatch.leftover import Leftover
    from omnimate.mismatch.model import Columns
    from omnimate.mismatch.regression import Regression
    from omnimate.mismatch.terms import Term
    from omnimate.mismatch.windows import Windows
    from omnimate.vehicle.se2 import Array

LOST = 2e-3  # [m] of a wheel's way in one moment, one standard deviation
SHOVE = np.array([3e-3, 3e-3, 1e-2])  # [m, m, rad] of a truck likewise
_EVENTS = 8
LASTING = 0.4  # [s] of a push
SHORT = 3.0  # [s] of a slip that may have been a push
_MOST = 30  # windows of free pushes that are worth comparing

Surprise = tuple["Term", list[list["Columns"]]]


def surprises(regression: Regression, left: Leftover, chosen: Sequence[Term]) -> list[Surprise]:
    """Return terms that a leftover calls for, each with its columns for every recording.

    Wherever a named event is chosen, a free push of a whole truck at the same moments stands against it.
    """
    return [*_pushes(regression, left), *_instead(regression, chosen), *beats(regression, left)]


def _instead(regression: Regression, chosen: Sequence[Term]) -> list[Surprise]:
    """Propose that what bumps and short slips stand for was a push of a truck."""
    moments = sorted(moment for term in chosen for moment in _moments(term))
    events = sorted(
        {
            (number, window)
            for number, windows in enumerate(regression.windows)
            for moment in moments
            for window in _about(windows.time[:-1], moment)
        }
    )
    if not 0 < len(events) <= _MOST:
        return []
    found: list[Surprise] = []
    for truck, name in enumerate(regression.windows[0].signals.trucks):
        levers = [shoves(windows, truck) for windows in regression.windows]
        term, columns = _pushed_at(regression, name, events, levers, _looked_for(chosen))
        found.append((replace(term, fixed={**term.fixed, "instead": True}), columns))
    return found


def _about(begins: Array, moment: float) -> list[int]:
    """Return the windows, by when they begin [s], in which what happens at a moment may push a truck."""
    inside = (begins > moment - WINDOW) & (begins < moment + LASTING)
    return [int(window) for window in np.flatnonzero(inside)]


def _looked_for(chosen: Sequence[Term]) -> int:
    """Return how many moments the events of a set were looked for at; a slip that lasts is one."""
    return sum(len(term.fixed["times"]) if term.effect == "bump" else bool(_moments(term)) for term in chosen)


def _moments(term: Term) -> tuple[float, ...]:
    """Return when an event of a term begins [s]; nothing for what lasts."""
    if term.effect == "bump":
        return tuple(term.fixed["times"])
    if term.effect == "slip_patch" and all(end - start < SHORT for start, end in term.fixed["intervals"]):
        return tuple(
            moment for start, end in term.fixed["intervals"] for moment in np.arange(start, end, WINDOW)
        )
    return ()


def _pushes(regression: Regression, left: Leftover) -> list[Surprise]:
    """Propose moments at which a wheel, or a truck as a whole, was moved by something."""
    seen = shocks(regression, left)
    found: list[Surprise] = []
    for component, numbers in sides(regression.windows[0]).items():
        if len(numbers) == 1:
            sigmas = [
                np.abs(lost_way(windows, *own)[1][:, numbers[0]]) * quiet(windows, left)
                for windows, own in zip(regression.windows, seen, strict=True)
            ]
            events = _events(sigmas, EVENT)
            levers = [windows.lever[:, numbers[0], :, None] * LOST for windows in regression.windows]
            found += _pushed(regression, component, events, levers)
    for number, truck in enumerate(regression.windows[0].signals.trucks):
        own = slice(3 * number, 3 * number + 3)
        powers = [
            power(scores[:, own], informations[:, own, own]) * quiet(windows, left)
            for windows, (scores, informations) in zip(regression.windows, seen, strict=True)
        ]
        events = _events([np.sqrt(own_power) for own_power in powers], EVENT + 0.6)
        found += _pushed(
            regression, truck, events, [shoves(windows, number) for windows in regression.windows]
        )
    return found


def _events(sigmas: list[Array], least: float) -> list[tuple[int, int]]:
    """Return recording and window of the strongest moments of all."""
    found = [
        (float(own[window]), number, window)
        for number, own in enumerate(sigmas)
        for window in apart(np.flatnonzero(own > least), own)
    ]
    return [(number, window) for _, number, window in sorted(found, reverse=True)[:_EVENTS]]


def power(scores: Array, informations: Array) -> Array:
    """Return the chi-square `(M,)` of a free push of a truck in each window."""
    solid = (
        informations + 1e-9 * np.eye(3) * np.maximum(np.einsum("mii->m", informations), 1e-9)[:, None, None]
    )
    return np.asarray(np.einsum("mi,mi->m", scores, np.linalg.solve(solid, scores[:, :, None])[:, :, 0]))


def shoves(windows: Windows, truck: int, sizes: Array = SHOVE) -> Array:
    """Return pushes (M, 3 T, 3) of a truck forward, to the left and about its centre."""
    middle = (windows.ends[1:] + windows.ends[:-1]) // 2
    heading = windows.signals.path[middle, truck, 2]
    pushes = np.zeros((len(middle), 3 * len(windows.signals.trucks), 3))
    cos, sin = np.cos(heading), np.sin(heading)
    first = 3 * truck
    pushes[:, first, 0], pushes[:, first + 1, 0] = cos, sin
    pushes[:, first, 1], pushes[:, first + 1, 1] = -sin, cos
    pushes[:, first + 2, 2] = 1.0
    return np.asarray(pushes * sizes)


def _pushed(
    regression: Regression, component: str, events: list[tuple[int, int]], pushes: list[Array]
) -> list[Surprise]:
    """Return terms of the strongest event alone, and of all of them."""
    counts = sorted({1, 2, 4, len(events)} & set(range(1, len(events) + 1)))
    return [_pushed_at(regression, component, events[:count], pushes, count) for count in counts]


def _pushed_at(
    regression: Regression,
    component: str,
    events: list[tuple[int, int]],
    pushes: list[Array],
    looked_for: int,
) -> Surprise:
    """Return the term of all events together; each moment was looked for among all windows."""
    columns: list[list[Columns]] = []
    for number, windows in enumerate(regression.windows):
        own: list[Columns] = []
        for owner, window in events:
            own += pushed_in(windows, pushes[number], window if owner == number else None)
        columns.append(own)
    times = tuple(float(regression.windows[owner].time[window]) for owner, window in events)
    found = unknown(component, MOMENTS, times)
    searched = looked_for * math.log(windows_in_all(regression))
    return replace(found, plausibility=found.plausibility - searched), columns


def pushed_in(windows: Windows, pushes: Array, window: int | None) -> list[Columns]:
    """Return a column for each direction (M, n, D) of a push in one window; zeros where it was elsewhere."""
    still, poses = np.zeros_like(windows.measured), windows.drift.shape[-1]
    columns: list[Columns] = []
    for number in range(pushes.shape[-1]):
        inputs = np.zeros_like(windows.drift)
        if window is not None:
            inputs[window] = -pushes[window, :poses, number]
        columns.append((inputs, still))
    return columns
