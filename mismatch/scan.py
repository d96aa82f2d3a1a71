"""Looking for effects at a place: where and when a wheel lost way, changed its size, or beats.

Proposals only: each is a term that then has to stand against all others. Bumps come from the filter's
adjoint, window by window; patches, steps and harmonics from columns at the windows' own pace.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omnimate.mismatch.choose import EMPTY
from omnimate.mismatch.leftover import (
    EVENT,
    apart,
    leftover,
    lost_way,
    quiet,
    shocks,
    strengths,
    travelled,
    wheels_of,
    windows_in_all,
)
from omnimate.mismatch.moments import lasts
from omnimate.mismatch.patches import patches
from omnimate.mismatch.terms import SCANNED, term

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.mismatch.choose import Choice, Set
    from omnimate.mismatch.leftover import Leftover
    from omnimate.mismatch.regression import Regression
    from omnimate.mismatch.terms import Term
    from omnimate.mismatch.windows import Windows
    from omnimate.vehicle.se2 import Array

ORDERS = tuple(range(2, 41))
_LIMITS = 40  # of speed above which counts may be lost
STEPPED = 48  # moments of a recording at which a step is looked for


def proposals(regression: Regression, choice: Choice, chosen: Set) -> list[Term]:
    """Return terms that a leftover calls for: bumps, patches, steps of the radius, gear harmonics.

    Patches and steps are also looked for as if nothing were chosen, where something smooth is that may
    stand for them.
    """
    left = leftover(regression, choice, chosen)
    lefts = [left]
    if chosen and not any(choice.terms[one].effect in SCANNED for one in chosen):
        lefts.append(leftover(regression, choice, EMPTY))
    found = [*_bumps(regression, left), *patches(regression, lefts), *_steps(regression, lefts)]
    return merged([], [*found, *_losses(regression, lefts), *_harmonics(regression, left)])


def _bumps(regression: Regression, left: Leftover) -> list[Term]:
    """Propose bumps under each wheel: all windows that stand out, and the strongest few of them."""
    peaks: dict[str, list[tuple[float, float]]] = {}
    for windows, (scores, informations) in zip(regression.windows, shocks(regression, left), strict=True):
        sigmas = lost_way(windows, scores, informations)[1] * quiet(windows, left)[:, None]
        for number, wheel in enumerate(map(str, windows.signals.recording.vehicle.wheels)):
            own = sigmas[:, number]
            best_of_all = own >= sigmas.max(axis=1) - 1e-9
            high = np.flatnonzero((own > EVENT) & best_of_all)
            for window in apart(high, own):
                peaks.setdefault(wheel, []).append((float(own[window]), float(windows.time[window])))
    tries, found = windows_in_all(regression), []
    for wheel, heights in peaks.items():
        ranked = sorted(heights, reverse=True)[:24]
        known = left.events.get(wheel, ())
        for count in sorted({1, 2, 4, 8, len(ranked)}):
            if count <= len(ranked):
                times = tuple(sorted([*known, *(time for _, time in ranked[:count])]))
                found.append(term("bump", wheel, tries, times=times))
    return found


def _steps(regression: Regression, lefts: Sequence[Leftover]) -> list[Term]:
    """Propose moments at which a wheel's radius changed, for each leftover."""
    wheels = wheels_of(regression)
    moments = [
        (number, float(moment))
        for number, windows in enumerate(regression.windows)
        for moment in np.linspace(windows.time[0], windows.time[-1], STEPPED + 2)[1:-1]
    ]

    def build(_number: int, windows: Windows, columns: range) -> Array:
        way = travelled(windows)
        middle = 0.5 * (windows.time[1:] + windows.time[:-1])
        gained = np.zeros((*way.shape, len(columns)))
        for at, column in enumerate(columns):
            (_, moment), wheel = moments[column // len(wheels)], column % len(wheels)
            late = middle > moment
            gained[late, wheel, at] = way[late, wheel]
        return gained

    found = []
    for own in np.abs(strengths(regression, lefts, build, len(moments) * len(wheels))):
        sigmas = own.reshape(-1, len(wheels))
        for number, wheel in enumerate(wheels):
            at = int(np.argmax(sigmas[:, number]))
            if sigmas[at, number] > EVENT:
                found.append(term("radius_step", wheel, len(moments), time=moments[at][1]))
    return [one for one in found if lasts(regression, one)]


def _losses(regression: Regression, lefts: Sequence[Leftover]) -> list[Term]:
    """Propose speeds above which a wheel's counts are lost, for each leftover."""
    wheels = wheels_of(regression)
    blocks = [windows.signals.block for windows in regression.windows]
    speeds = np.abs(np.concatenate([one.speed for one in blocks]))
    limits = np.quantile(speeds, np.linspace(0.02, 0.98, _LIMITS), axis=0)

    def build(number: int, windows: Windows, columns: range) -> Array:
        block = blocks[number]
        gained = np.zeros((len(windows.ends) - 1, len(wheels), len(columns)))
        for at, column in enumerate(columns):
            limit, wheel = divmod(column, len(wheels))
            fast = np.abs(block.speed[:, wheel]) > limits[limit, wheel]
            lost = np.where(fast, block.travel[:, wheel], 0.0)
            gained[:, wheel, at] = np.add.reduceat(lost, windows.ends[:-1])
        return gained

    found = []
    for own in strengths(regression, lefts, build, len(limits) * len(wheels)):
        sigmas = own.reshape(len(limits), len(wheels))
        for number, wheel in enumerate(wheels):
            at = int(np.argmax(sigmas[:, number]))
            if sigmas[at, number] > EVENT and limits[at, number] > 0.0:
                found.append(
                    term("count_loss", wheel, len(limits), above=round(float(limits[at, number]), 4))
                )
    return found


def _harmonics(regression: Regression, left: Leftover) -> list[Term]:
    """Propose an order at which a wheel's travel beats."""
    wheels = wheels_of(regression)

    def build(_number: int, windows: Windows, columns: range) -> Array:
        gained = np.zeros((len(windows.ends) - 1, len(wheels), len(columns)))
        for at, column in enumerate(columns):
            wheel, rest = divmod(column, 2 * len(ORDERS))
            angle = windows.signals.block.angle[:, wheel]
            turned = np.concatenate((angle[:1], angle))[windows.ends]
            wave = np.cos(ORDERS[rest // 2] * turned + 0.5 * np.pi * (rest % 2))
            gained[:, wheel, at] = np.diff(wave)
        return gained

    sigmas = strengths(regression, [left], build, 2 * len(ORDERS) * len(wheels))
    power = (sigmas.reshape(len(wheels), len(ORDERS), 2) ** 2).sum(axis=2)
    found = []
    for number, wheel in enumerate(wheels):
        found += [
            term("gear_harmonic", wheel, len(ORDERS), order=float(ORDERS[at]))
            for at in np.argsort(-power[number])[:2]
            if power[number, at] > EVENT**2
        ]
    return found


def merged(known: Sequence[Term], new: Sequence[Term]) -> list[Term]:
    """Return the new terms that are not among the known ones."""
    seen, fresh = [(one.key, one.fixed) for one in known], []
    for one in new:
        if (one.key, one.fixed) not in seen:
            seen.append((one.key, one.fixed))
            fresh.append(one)
    return fresh
