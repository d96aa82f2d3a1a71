"""What acts at a place or time: where a wheel lost way, slipped, changed its size, or beats.

Candidates only: each has to stand against all others. Bumps come from the disturbance smoother, window by
window (de Jong & Penzer, JASA 1998); stretches, steps and harmonics from columns at the windows' pace.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from omnimate.effects import effects_scanned_by
from omnimate.mismatch.candidates.pushes import push
from omnimate.mismatch.candidates.terms import EVENT_MARGIN, term
from omnimate.mismatch.recording.signals import WINDOW
from omnimate.mismatch.scans.disturbances import power
from omnimate.mismatch.scans.nonlinear import SHORTEST, lasts, refine

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from omnimate.mismatch.candidates.regression import Regression
    from omnimate.mismatch.candidates.terms import Term
    from omnimate.mismatch.diagnosis import Key
    from omnimate.mismatch.evidence.conditional_fit import ConditionalFit
    from omnimate.mismatch.recording.windows import Windows
    from omnimate.vehicle.parameters import Channel
    from omnimate.vehicle.se2 import Array

SEEN = 3.5  # sigma from which a place is a candidate; its odds pay for how many places there are
PUSHED = 6.0  # sigma of what is plain: a push of three numbers that noise makes of none of a million windows
FALLEN = (0.3, 0.5, 0.7)  # of a peak's strength, at which a push may begin and end
LASTING = 2  # windows from which a push is a stretch: it may be a moment on the edge of both
# Onsets of a bump, in windows after the begin of the one that shows it: a slow wheel takes half a second to
# pass an obstacle, and shows it best at the end.
ONSETS = tuple(0.25 * quarter for quarter in range(-6, 4))
ORDERS = tuple(range(2, 41))
_LIMITS = 24  # speeds above which counts may be lost
CELLS = 240  # of a recording, however long that is
_PLACES = 4  # stretches under one wheel that are looked at
_STRONGEST = 16  # windows under one wheel

PushScores = Sequence[tuple["Array", "Array"]]  # of each recording, as `Regression.shocks` gives them


def events(
    regression: Regression, conditionals: Sequence[ConditionalFit], *, nameless: bool = True
) -> list[Term]:
    """Return candidates that act at a place or time, as what is left beside some sets shows them.

    Args:
        regression: Whose recordings to look at.
        conditionals: Their fits given some sets.
        nameless: Whether pushes are offered: not before the events that have names are where they belong.
    """
    shocks = [regression.push_scores(conditional.residual) for conditional in conditionals]
    found = [
        *(
            single
            for conditional, seen in zip(conditionals, shocks, strict=True)
            for single in _bumps(regression, conditional, seen)
        ),
        *(push_terms(regression, shocks) if nameless else ()),
        *spans(regression, conditionals),
        *_losses(regression, conditionals),
        *_harmonics(regression, conditionals),
    ]
    return merged([], found)


def _bumps(regression: Regression, conditional: ConditionalFit, shocks: PushScores) -> list[Term]:
    """Return bumps under each wheel: the windows that stand out."""
    found = []
    tries = _windows(regression)
    for windows, (scores, informations) in zip(regression.windows, shocks, strict=True):
        sigmas = lost_travel_z_scores(windows, scores, informations)
        for number, wheel in enumerate(map(str, windows.signals.recording.vehicle.wheels)):
            for kind in effects_scanned_by("moments", wheel):
                rolls_on = _rolls_on(windows, number, kind.estimated().scale)
                own = np.where(rolls_on, sigmas[:, number], 0.0)
                high = np.flatnonzero(own > SEEN)
                begins = [float(windows.time[window]) for window in _separated(high, own)[:_STRONGEST]]
                found += _begun(regression, conditional, (kind.name, wheel), begins, tries)
    return found


def push_terms(regression: Regression, shocks: Sequence[PushScores]) -> list[Term]:
    """Return pushes of each truck, in one window or over a stretch.

    Args:
        regression: Whose recordings to look at.
        shocks: Of what is left of them beside some sets.
    """
    found: list[Term] = []
    tries = _windows(regression)
    for seen in shocks:
        for windows, (scores, informations) in zip(regression.windows, seen, strict=True):
            for number, truck in enumerate(windows.signals.trucks):
                part = slice(3 * number, 3 * number + 3)
                strength = np.sqrt(power(scores[:, part], informations[:, part, part]))
                peaks = _separated(np.flatnonzero(strength > PUSHED), strength)[:_STRONGEST]
                found += [push(truck, float(windows.time[window]), tries) for window in peaks]
                found += [
                    push(truck, begin, tries**2 // 2, end - begin)
                    for begin, end in _lasting(windows.time, strength, peaks)
                ]
    return merged([], found)


def _windows(regression: Regression) -> int:
    """Return how many windows all recordings have."""
    return sum(len(windows.ends) for windows in regression.windows)


def _lasting(time: Array, strength: Array, peaks: Sequence[int]) -> list[tuple[float, float]]:
    """Return stretches of windows (begin, end) [s] about peaks in which a truck is pushed all the time.

    A displacement at a constant pace shows in each of its windows, and less in those beside it, which share
    its readings: its bounds are where the strength has fallen to some part of the peak's.

    Args:
        time: Of the windows' ends `(M + 1,)` [s].
        strength: By how many sigma a truck is pushed in each window, `(M,)`.
        peaks: Windows that stand out, the strongest first.
    """
    found = set()
    covered = np.zeros(len(strength), bool)
    for peak in peaks:
        if covered[peak]:
            continue
        for part in FALLEN:
            low = np.flatnonzero(strength < part * strength[peak])
            at = int(np.searchsorted(low, peak))
            first = int(low[at - 1]) + 1 if at > 0 else 0
            last = int(low[at]) if at < len(low) else len(strength)
            covered[first:last] = True
            if last - first >= LASTING:
                found.add((float(time[first]), float(time[last])))
    return sorted(found)


def _rolls_on(windows: Windows, wheel: int, lost: float) -> NDArray[np.bool_]:
    """Say in which windows (M,) a wheel rolls, within a second, the distance [m] that an obstacle takes.

    No wheel loses more way than it rolls.
    """
    ahead = np.convolve(windows.rolled[:, wheel], np.ones(round(EVENT_MARGIN / WINDOW)))[
        -len(windows.rolled) :
    ]
    return np.asarray(ahead > lost)


def _begun(
    regression: Regression, conditional: ConditionalFit, key: Key, windows: Sequence[float], tries: int
) -> list[Term]:
    """Return events of an effect and wheel in windows that begin at some times [s].

    The onset of each is where it is seen best.
    """
    offers = [term(*key, tries, times=(begin + shift * WINDOW,)) for begin in windows for shift in ONSETS]
    if not offers:
        return []
    sigmas = conditional.z_scores(regression.columns_of(offers)).reshape(len(windows), len(ONSETS))
    return [offers[len(ONSETS) * row + int(np.argmax(own))] for row, own in enumerate(sigmas)]


def lost_travel_z_scores(windows: Windows, scores: Array, informations: Array) -> Array:
    """Return by how many sigma each wheel lost way in each window, `(M, W)`."""
    lever = -np.sign(travelled(windows))[:, :, None] * windows.lever
    score = np.einsum("mwn,mn->mw", lever, scores)
    information = np.einsum("mwi,mij,mwj->mw", lever, informations, lever)
    return np.where(information > 0.0, score / np.sqrt(np.maximum(information, 1e-300)), 0.0)


def _separated(high: NDArray[np.int64], sigmas: Array) -> list[int]:
    """Return the strongest of windows that lie next to each other, the strongest first."""
    chosen: list[int] = []
    for window in sorted(high.tolist(), key=lambda at: -sigmas[at]):
        if all(abs(window - other) > 2 for other in chosen):
            chosen.append(window)
    return chosen


def spans(regression: Regression, conditionals: Sequence[ConditionalFit], most: int = CELLS) -> list[Term]:
    """Return stretches of time in which wheels slipped, and moments at which their radius changed.

    A recording is cut into cells; the column of a stretch is the sum of those of its cells, and so all
    stretches of whole cells are compared at once.

    Args:
        regression: Whose recordings to look at.
        conditionals: Their fits given some sets.
        most: Cells of a recording, at most.
    """
    edges = [_cells(windows, most) for windows in regression.windows]
    counts = [len(own) - 1 for own in edges]
    firsts = np.concatenate(([0], np.cumsum(counts)))
    begins = np.concatenate([own[:-1] for own in edges])
    places = _windows(regression)
    found = []
    for number, wheel in enumerate(wheels_of(regression)):
        ways = [np.zeros((len(windows.rolled), firsts[-1])) for windows in regression.windows]
        for own, windows, cells, first in zip(ways, regression.windows, edges, firsts, strict=False):
            middle = 0.5 * (windows.time[1:] + windows.time[:-1])
            inside = np.arange(np.searchsorted(middle, cells[0]), np.searchsorted(middle, cells[-1]))
            cell = np.searchsorted(cells, middle[inside], side="right") - 1
            own[inside, first + cell] = -travelled(windows)[inside, number]
        columns = regression.whiten_travel(number, ways)
        for conditional in conditionals:
            gram, score = conditional.products_of(columns)
            offers = _steps(wheel, begins, score, gram, places)
            for own, first, end in zip(edges, firsts, firsts[1:], strict=False):
                mine = slice(first, end)
                offers += _slips(wheel, own, score[mine], gram[mine, mine], places**2 // 2)
            found += _bounded(regression, conditional, [each for each in offers if lasts(regression, each)])
    return found


def _bounded(regression: Regression, conditional: ConditionalFit, offers: Sequence[Term]) -> list[Term]:
    """Return stretches, steps and losses, the plain ones with their bounds where they are seen best.

    What a plain one leaves by bounds that are off by a part of a cell is far more than noise, and would count
    against it.
    """
    if not offers:
        return []
    sigmas = np.abs(conditional.z_scores(regression.columns_of(offers)))
    return [
        refine(regression, conditional, single) if strong > PUSHED else single
        for single, strong in zip(offers, sigmas.tolist(), strict=True)
    ]


def _cells(windows: Windows, most: int) -> Array:
    """Return the edges of a recording's cells [s]."""
    start, end = float(windows.time[0]), float(windows.time[-1])
    count = int(np.clip((end - start) / SHORTEST, 1, most))
    return np.linspace(start, end, count + 1)


def _slips(wheel: str, edges: Array, score: Array, gram: Array, tries: int) -> list[Term]:
    """Return the stretches, at most a few, that stand out most, none overlapping another.

    Args:
        wheel: Under which they are.
        edges: Of the K cells [s], shape `(K + 1,)`.
        score: Products of the cells' columns with the data, shape `(K,)`.
        gram: Of them with each other, shape `(K, K)`.
        tries: Stretches that share the odds: a begin and an end at any of the windows.
    """
    count = len(score)
    along = np.concatenate(([0.0], np.cumsum(score)))
    area = np.zeros((count + 1, count + 1))
    area[1:, 1:] = gram.cumsum(axis=0).cumsum(axis=1)
    diagonal = np.diagonal(area)
    power = diagonal[None, :] + diagonal[:, None] - area - area.T  # of the cells from row to column
    start, end = np.triu_indices(count + 1, 1)
    sigmas = (along[end] - along[start]) / np.sqrt(np.maximum(power[start, end], 1e-12))
    sigmas[2 * (end - start) > count] = 0.0  # a wheel that slips nearly always is a smaller wheel
    found = []
    for _ in range(_PLACES):
        at = int(np.argmax(sigmas))
        if sigmas[at] < SEEN:
            break
        span = (float(edges[start[at]]), float(edges[end[at]]))
        found += [
            term(kind.name, wheel, tries, intervals=(span,)) for kind in effects_scanned_by("interval", wheel)
        ]
        sigmas[(start < end[at]) & (end > start[at])] = 0.0
    return found


def _steps(wheel: str, moments: Array, score: Array, gram: Array, tries: int) -> list[Term]:
    """Return the moment [s] of all cells' (K,) beginnings at which a radius changed most, if it did."""
    count = len(score)
    after = np.cumsum(score[::-1])[::-1]
    power = np.diagonal(gram[::-1, ::-1].cumsum(axis=0).cumsum(axis=1))[::-1]
    sigmas = np.abs(after) / np.sqrt(np.maximum(power, 1e-12))
    at = int(np.argmax(sigmas[1:])) + 1 if count > 1 else 0
    if at == 0 or sigmas[at] < SEEN:
        return []
    time = float(moments[at])
    return [term(kind.name, wheel, tries, time=time) for kind in effects_scanned_by("step", wheel)]


def _losses(regression: Regression, conditionals: Sequence[ConditionalFit]) -> list[Term]:
    """Return speeds above which a wheel's counts are lost."""
    found: list[list[Term]] = [[] for _ in conditionals]
    blocks = [windows.signals.block for windows in regression.windows]
    for number, wheel in enumerate(wheels_of(regression)):
        speeds = [np.abs(block.speed[:, number]) for block in blocks]
        limits = np.quantile(np.concatenate(speeds), np.linspace(0.02, 0.98, _LIMITS))
        ways = [
            np.add.reduceat(
                np.where(speed[:, None] > limits, block.travel[:, number, None], 0.0), windows.ends[:-1]
            )
            for speed, block, windows in zip(speeds, blocks, regression.windows, strict=True)
        ]
        columns = regression.whiten_travel(number, ways)
        for conditional, offers in zip(conditionals, found, strict=True):
            sigmas = conditional.z_scores(columns)
            at = int(np.argmax(sigmas))
            if sigmas[at] > SEEN and limits[at] > 0.0:
                above = round(float(limits[at]), 4)
                for kind in effects_scanned_by("threshold", wheel):
                    offer = term(kind.name, wheel, len(limits), above=above)
                    offers.extend(_bounded(regression, conditional, [offer]))
    return [single for offers in found for single in offers]


def _harmonics(regression: Regression, conditionals: Sequence[ConditionalFit]) -> list[Term]:
    """Return orders at which a wheel's travel beats."""
    found: list[list[Term]] = [[] for _ in conditionals]
    for number, wheel in enumerate(wheels_of(regression)):
        ways = []
        for windows in regression.windows:
            angle = windows.signals.block.angle[:, number]
            turned = np.outer(np.concatenate((angle[:1], angle))[windows.ends], np.repeat(ORDERS, 2))
            quarter = np.tile([0.0, 0.5 * np.pi], len(ORDERS))
            ways.append(np.diff(np.cos(turned + quarter), axis=0))
        columns = regression.whiten_travel(number, ways)
        for conditional, offers in zip(conditionals, found, strict=True):
            power = (conditional.z_scores(columns).reshape(len(ORDERS), 2) ** 2).sum(axis=1)
            offers.extend(
                term(kind.name, wheel, len(ORDERS), order=float(ORDERS[at]))
                for kind in effects_scanned_by("order", wheel)
                for at in np.argsort(-power)[:2]
                if power[at] > SEEN**2
            )
    return [single for offers in found for single in offers]


def merged(known: Sequence[Term], new: Sequence[Term]) -> list[Term]:
    """Return the new candidates that are not among the known."""
    seen, fresh = [(single.key, single.fixed, single.size) for single in known], []
    for single in new:
        if (single.key, single.fixed, single.size) not in seen:
            seen.append((single.key, single.fixed, single.size))
            fresh.append(single)
    return fresh


def travelled(windows: Windows) -> Array:
    """Return the way (M, W) of each wheel in each window [m]."""
    return np.asarray(np.add.reduceat(windows.signals.block.travel, windows.ends[:-1], axis=0))


def wheels_of(regression: Regression) -> tuple[Channel, ...]:
    """Return the wheels of the robot."""
    return regression.windows[0].signals.recording.vehicle.wheels
