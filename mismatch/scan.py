"""Looking for effects at a place: where and when a wheel lost way, changed its size, or beats.

Proposals only: each is a term that then has to stand against all others. Bumps come from the filter's
adjoint, window by window; patches, steps and harmonics from columns at the windows' own pace.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mismatch.choose import EMPTY
from mismatch.signals import WINDOW
from mismatch.terms import SCANNED, term
from mismatch.whitening import adjoint

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from mismatch.choose import Choice, Set
    from mismatch.regression import Regression
    from mismatch.terms import Term
    from mismatch.windows import Windows
    from vehicle.parameters import Channel
    from vehicle.se2 import Array

EVENT = 4.0  # sigma from which one window among a thousand is worth a look
NEAR = 1.0  # [s] about an event, in which no other is looked for
ORDERS = tuple(range(2, 41))
_SHORTEST = 1.5  # [s] of a patch
_PATCHES = 200  # of the shortest kind in a recording, however long that is
_MOMENTS = 48  # of a recording at which a step is looked for
_CHUNK = 256

Build = Callable[[int, "Windows", range], "Array"]
Slip = tuple[tuple[int, float, float], int]  # recording, start and end [s], and wheel


@dataclass(frozen=True, slots=True)
class Leftover:
    """What a set of terms leaves.

    Attributes:
        rows: (V,) whitened residual.
        columns: (V, k) whitened columns of the set.
        inverse: (k, k) inverse of their products, with the prior.
        events: of each wheel, moments [s] at which the set already has a bump.
    """

    rows: Array
    columns: Array
    inverse: Array
    events: dict[str, tuple[float, ...]]

    def strength(self, added: Array) -> Array:
        """Return by how many sigma (C,) each of added columns (V, C) would be estimated, signed."""
        shared = self.columns.T @ added
        free = np.einsum("vc,vc->c", added, added) - np.einsum("kc,kl,lc->c", shared, self.inverse, shared)
        return np.asarray((self.rows @ added) / np.sqrt(np.maximum(free, 1e-12)))


def leftover(regression: Regression, choice: Choice, chosen: Set) -> Leftover:
    """Return what a set of terms leaves of a recording."""
    columns = choice.columns(chosen)
    coefficients, covariance = choice.solved(chosen)
    own = regression.white[:, columns]
    bumps = [choice.terms[one] for one in chosen if choice.terms[one].effect == "bump"]
    events = {one.component: one.fixed["times"] for one in bumps}
    return Leftover(regression.white[:, 0] - own @ coefficients, own, covariance / choice.spread, events)


def proposals(regression: Regression, choice: Choice, chosen: Set) -> list[Term]:
    """Return terms that a leftover calls for: bumps, patches, steps of the radius, gear harmonics.

    Patches and steps are also looked for as if nothing were chosen, where something smooth is that may
    stand for them.
    """
    left = leftover(regression, choice, chosen)
    found = _bumps(regression, left)
    for build in (_patches, _steps, _harmonics):
        found += build(regression, left)
    if chosen and not any(choice.terms[one].effect in SCANNED for one in chosen):
        nothing = leftover(regression, choice, EMPTY)
        found += _patches(regression, nothing) + _steps(regression, nothing)
    return merged([], found)


def shocks(regression: Regression, left: Leftover) -> list[tuple[Array, Array]]:
    """Return of each recording the scores `(M, n)` and informations `(M, n, n)` of a push in each window."""
    answers = []
    for number, (windows, run) in enumerate(zip(regression.windows, regression.filters, strict=True)):
        white = np.full(run.spread.shape, np.nan)
        mine = regression.owner == number
        white[regression.moment[mine], regression.channel[mine]] = left.rows[mine]
        answers.append(adjoint(run.transition, windows.observe, run.gains, run.spread, white))
    return answers


def quiet(windows: Windows, left: Leftover) -> Array:
    """Return 1.0 for windows `(M,)` away from known events, whose shape is never met exactly, else 0.0."""
    middle = 0.5 * (windows.time[1:] + windows.time[:-1])
    near = np.zeros(len(middle), bool)
    for moments in left.events.values():
        for moment in moments:
            near |= np.abs(middle - moment) < NEAR
    return np.where(near, 0.0, 1.0)


def lost_way(windows: Windows, scores: Array, informations: Array) -> tuple[Array, Array]:
    """Return the way (M, W) that each wheel lost in each window [m], and by how many sigma."""
    rolled = np.add.reduceat(windows.signals.block.travel, windows.ends[:-1], axis=0)
    lever = -np.sign(rolled)[:, :, None] * windows.lever
    score = np.einsum("mwn,mn->mw", lever, scores)
    information = np.einsum("mwi,mij,mwj->mw", lever, informations, lever)
    sure = information > 0.0
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(sure, score / information, 0.0), np.where(sure, score / np.sqrt(information), 0.0)


def windows_in_all(regression: Regression) -> int:
    """Return among how many windows a moment is looked for."""
    return sum(len(windows.ends) for windows in regression.windows)


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


def apart(high: NDArray[np.int64], sigmas: Array) -> list[int]:
    """Return the strongest of windows that lie next to each other."""
    chosen: list[int] = []
    for window in sorted(high.tolist(), key=lambda one: -sigmas[one]):
        if all(abs(window - other) > 2 for other in chosen):
            chosen.append(window)
    return chosen


def strengths(regression: Regression, left: Leftover, build: Build, count: int) -> Array:
    """Return by how many sigma each of many columns would be estimated, `(C,)`.

    Args:
        regression: whose recordings to look at.
        left: what is left of them.
        build: the way that wheels gain (M, W, c) in the columns from one number to another.
        count: C.
    """
    answer = np.zeros(count)
    for first in range(0, count, _CHUNK):
        last = min(first + _CHUNK, count)
        white = []
        for number, windows in enumerate(regression.windows):
            gained = build(number, windows, range(first, last))
            poses = 3 * len(windows.signals.trucks)
            push = np.einsum("mwi,mwc->mic", windows.lever[:, :, :poses], gained)
            still = np.zeros((*windows.measured.shape, last - first))
            white.append(regression.filters[number].whiten(-push, still))
        answer[first:last] = left.strength(regression.rows(white))
    return answer


def _travelled(windows: Windows) -> Array:
    """Return the way (M, W) of each wheel in each window [m]."""
    return np.add.reduceat(windows.signals.block.travel, windows.ends[:-1], axis=0)


def _wheels(regression: Regression) -> tuple[Channel, ...]:
    return regression.windows[0].signals.recording.vehicle.wheels


def _patches(regression: Regression, left: Leftover) -> list[Term]:
    """Propose a stretch of time in which a wheel slipped, of any length, at any place."""
    spans = [
        (number, start, start + length)
        for number, windows in enumerate(regression.windows)
        for start, length in _stretches(windows.time[0], windows.time[-1])
    ]
    wheels = _wheels(regression)
    everywhere = [(span, number) for span in spans for number in range(len(wheels))]
    sigmas = _slips(regression, left, everywhere).reshape(len(spans), len(wheels))
    best = [(spans[int(np.argmax(own))], number) for number, own in enumerate(sigmas.T) if own.max() > EVENT]
    found = [
        (spans[at], number) for number in range(len(wheels)) for at in np.argsort(-sigmas[:, number])[:2]
    ]
    slips = [one for one in found if sigmas[spans.index(one[0]), one[1]] > EVENT]
    slips += _sharpened(regression, left, best)
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
        sigmas = _slips(regression, left, tried).reshape(len(best), len(moves))
        best = [tried[len(moves) * row + int(np.argmax(own))] for row, own in enumerate(sigmas)]
        step /= 2.0
    return best


def _slips(regression: Regression, left: Leftover, slips: Sequence[Slip]) -> Array:
    """Return by how many sigma each slip would be estimated."""

    def build(number: int, windows: Windows, columns: range) -> Array:
        way = _travelled(windows)
        middle = 0.5 * (windows.time[1:] + windows.time[:-1])
        gained = np.zeros((*way.shape, len(columns)))
        for at, column in enumerate(columns):
            (owner, start, end), wheel = slips[column]
            if owner == number:
                inside = slice(*np.searchsorted(middle, (start, end)))
                gained[inside, wheel, at] = -way[inside, wheel]
        return gained

    return strengths(regression, left, build, len(slips))


def _stretches(start: float, end: float) -> list[tuple[float, float]]:
    """Return starts and lengths that overlap by half, each length twice the one before."""
    found, length = [], max(_SHORTEST, (end - start) / _PATCHES)
    while length < 0.6 * (end - start):
        found += [(float(at), length) for at in np.arange(start, end - 0.5 * length, 0.5 * length)]
        length *= 2.0
    return found


def _steps(regression: Regression, left: Leftover) -> list[Term]:
    """Propose a moment at which a wheel's radius changed."""
    wheels = _wheels(regression)
    moments = [
        (number, float(moment))
        for number, windows in enumerate(regression.windows)
        for moment in np.linspace(windows.time[0], windows.time[-1], _MOMENTS + 2)[1:-1]
    ]

    def build(_number: int, windows: Windows, columns: range) -> Array:
        way = _travelled(windows)
        middle = 0.5 * (windows.time[1:] + windows.time[:-1])
        gained = np.zeros((*way.shape, len(columns)))
        for at, column in enumerate(columns):
            (_, moment), wheel = moments[column // len(wheels)], column % len(wheels)
            late = middle > moment
            gained[late, wheel, at] = way[late, wheel]
        return gained

    sigmas = np.abs(strengths(regression, left, build, len(moments) * len(wheels))).reshape(-1, len(wheels))
    found = []
    for number, wheel in enumerate(wheels):
        at = int(np.argmax(sigmas[:, number]))
        if sigmas[at, number] > EVENT:
            found.append(term("radius_step", wheel, len(moments), time=moments[at][1]))
    return found


def _harmonics(regression: Regression, left: Leftover) -> list[Term]:
    """Propose an order at which a wheel's travel beats."""
    wheels = _wheels(regression)

    def build(_number: int, windows: Windows, columns: range) -> Array:
        gained = np.zeros((len(windows.ends) - 1, len(wheels), len(columns)))
        for at, column in enumerate(columns):
            wheel, rest = divmod(column, 2 * len(ORDERS))
            angle = windows.signals.block.angle[:, wheel]
            turned = np.concatenate((angle[:1], angle))[windows.ends]
            wave = np.cos(ORDERS[rest // 2] * turned + 0.5 * np.pi * (rest % 2))
            gained[:, wheel, at] = np.diff(wave)
        return gained

    sigmas = strengths(regression, left, build, 2 * len(ORDERS) * len(wheels))
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
