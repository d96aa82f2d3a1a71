"""Scans for candidates that act at a place or time: lost travel, slip, steps of a radius, and harmonics.

They are candidates only, which the search compares with all others. Bumps come from the disturbance smoother,
window by window (de Jong & Penzer, JASA 1998); intervals, steps and harmonics from columns of travel in each
window.
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
    from omnimate.mismatch.evidence.conditional_fit import ConditionalFit
    from omnimate.mismatch.recording.windows import Windows
    from omnimate.vehicle.se2 import Array

SEEN = 3.5  # standard deviations from which a place is a candidate; its odds pay for the number of places
# Standard deviations of a clear disturbance: the chi-square of a push exceeds 36, with three degrees of
# freedom, in fewer than one in ten million windows of noise.
CLEAR = 6.0
BOUNDS = (0.3, 0.5, 0.7)  # fractions of a peak's strength at which a push may begin and end
MIN_PUSH_WINDOWS = 2  # of a push that lasts: a single moment may be on the edge of both
# [windows] onsets of a bump after the begin of the window that shows it: a slow wheel takes half a second to
# pass an obstacle, and shows it best at the end.
ONSETS = tuple(0.25 * quarter for quarter in range(-6, 4))
ORDERS = tuple(range(2, 41))  # harmonics of a wheel's turn
MAX_CELLS = 240  # of a recording; they bound the cost of the scan
_LIMITS = 24  # speeds above which counts may be lost
_MAX_INTERVALS = 4  # candidates of slip under one wheel
_MAX_MOMENTS = 16  # candidates of bumps under one wheel, and of pushes of one truck

PushScores = Sequence[tuple["Array", "Array"]]  # of each recording, as `Regression.push_scores` gives them


def events(
    regression: Regression, conditionals: Sequence[ConditionalFit], *, nameless: bool = True
) -> list[Term]:
    """Return candidates that act at a place or time, given some sets of effects.

    Pushes, which are nameless, must wait until the named events have their final moments.
    """
    scores = [regression.push_scores(conditional.residual) for conditional in conditionals]
    candidates = []
    for conditional, of_set in zip(conditionals, scores, strict=True):
        candidates += _bumps(regression, conditional, of_set)
    if nameless:
        candidates += push_terms(regression, scores)
    candidates += spans(regression, conditionals)
    candidates += _losses(regression, conditionals)
    candidates += _harmonics(regression, conditionals)
    return candidates


def _bumps(regression: Regression, conditional: ConditionalFit, push_scores: PushScores) -> list[Term]:
    """Return bumps under each wheel in the windows with the most significant loss of travel.

    The onset of each is the most significant one of `ONSETS`.
    """
    bumps = []
    tries = regression.window_count
    for windows, (scores, informations) in zip(regression.windows, push_scores, strict=True):
        z_scores = lost_travel_z_scores(windows, scores, informations)
        for number, wheel in enumerate(map(str, windows.signals.wheels)):
            for kind in effects_scanned_by("moments", wheel):
                rolls_on = _rolls_on(windows, number, kind.estimated().scale)
                of_wheel = np.where(rolls_on, z_scores[:, number], 0.0)
                peaks = _separated(np.flatnonzero(of_wheel > SEEN), of_wheel)[:_MAX_MOMENTS]
                if not peaks:
                    continue
                begins = windows.time[peaks, None] + WINDOW * np.array(ONSETS)
                offers = [term(kind.name, wheel, tries, times=(time,)) for time in begins.ravel().tolist()]
                significance = conditional.z_scores(regression.columns_of(offers)).reshape(begins.shape)
                best = np.argmax(significance, axis=1) + len(ONSETS) * np.arange(len(peaks))
                bumps += [offers[at] for at in best]
    return bumps


def push_terms(regression: Regression, push_scores: Sequence[PushScores]) -> list[Term]:
    """Return pushes of each truck, in one window or over an interval, by their scores given some sets."""
    pushes: list[Term] = []
    tries = regression.window_count
    for of_set in push_scores:
        for windows, (scores, informations) in zip(regression.windows, of_set, strict=True):
            for number, truck in enumerate(windows.signals.trucks):
                pose = slice(3 * number, 3 * number + 3)
                strength = np.sqrt(power(scores[:, pose], informations[:, pose, pose]))
                peaks = _separated(np.flatnonzero(strength > CLEAR), strength)[:_MAX_MOMENTS]
                pushes += [push(truck, float(windows.time[window]), tries) for window in peaks]
                pushes += [
                    push(truck, begin, tries**2 // 2, end - begin)
                    for begin, end in _lasting(windows.time, strength, peaks)
                ]
    return pushes


def _lasting(time: Array, strength: Array, peaks: Sequence[int]) -> list[tuple[float, float]]:
    """Return intervals (begin, end) [s] about peaks in which a truck is pushed in every window.

    A displacement at constant speed is significant in each of its windows, and less in the adjacent ones,
    which share its readings: its bounds are where the strength falls to some fraction of the peak's.
    `strength` (M,) is a push's significance in each window, and `peaks` are its maxima, the largest first.
    """
    intervals = set()
    covered = np.zeros(len(strength), bool)
    for peak in peaks:
        if covered[peak]:
            continue
        for part in BOUNDS:
            low = np.flatnonzero(strength < part * strength[peak])
            at = int(np.searchsorted(low, peak))
            first = int(low[at - 1]) + 1 if at > 0 else 0
            last = int(low[at]) if at < len(low) else len(strength)
            covered[first:last] = True
            if last - first >= MIN_PUSH_WINDOWS:
                intervals.add((float(time[first]), float(time[last])))
    return sorted(intervals)


def _rolls_on(windows: Windows, wheel: int, lost: float) -> NDArray[np.bool_]:
    """Say in which windows (M,) a wheel rolls, within `EVENT_MARGIN`, the distance [m] that it would lose.

    No wheel loses more travel than it rolls.
    """
    ahead = np.convolve(windows.rolled[:, wheel], np.ones(round(EVENT_MARGIN / WINDOW)))
    return np.asarray(ahead[-len(windows.rolled) :] > lost)


def lost_travel_z_scores(windows: Windows, scores: Array, informations: Array) -> Array:
    """Return the z score of travel that each wheel lost in each window, `(M, W)`."""
    lever = -np.sign(travelled(windows))[:, :, None] * windows.lever
    score = np.einsum("mwn,mn->mw", lever, scores)
    information = np.einsum("mwi,mij,mwj->mw", lever, informations, lever)
    return np.where(information > 0.0, score / np.sqrt(np.maximum(information, 1e-300)), 0.0)


def _separated(high: NDArray[np.int64], z_scores: Array) -> list[int]:
    """Return the local maxima of z scores among some windows, more than two windows apart, largest first."""
    chosen: list[int] = []
    for window in sorted(high.tolist(), key=lambda at: -z_scores[at]):
        if all(abs(window - other) > 2 for other in chosen):
            chosen.append(window)
    return chosen


def spans(
    regression: Regression, conditionals: Sequence[ConditionalFit], max_cells: int = MAX_CELLS
) -> list[Term]:
    """Return intervals in which wheels slipped, and moments at which their radius changed.

    A recording is divided into cells of time; the column of an interval is the sum of those of its cells, and
    so all intervals of whole cells are compared at once.
    """
    edges = [_cells(windows, max_cells) for windows in regression.windows]
    firsts = np.cumsum([0, *(len(of_recording) - 1 for of_recording in edges)])
    begins = np.concatenate([of_recording[:-1] for of_recording in edges])
    tries = regression.window_count
    candidates = []
    for number, wheel in enumerate(regression.windows[0].signals.wheels):
        travel = [
            _travel_of_cells(windows, number, cells, first, int(firsts[-1]))
            for windows, cells, first in zip(regression.windows, edges, firsts.tolist(), strict=False)
        ]
        columns = regression.whiten_travel(number, travel)
        for conditional in conditionals:
            gram, score = conditional.products_of(columns)
            offers = _steps(wheel, begins, score, gram, tries)
            for of_recording, first, last in zip(edges, firsts, firsts[1:], strict=False):
                cells = slice(first, last)
                offers += _slips(wheel, of_recording, score[cells], gram[cells, cells], tries**2 // 2)
            candidates += _bounded(regression, conditional, [o for o in offers if lasts(regression, o)])
    return candidates


def _travel_of_cells(windows: Windows, wheel: int, edges: Array, first: int, count: int) -> Array:
    """Return minus a wheel's travel (M, count) in each window [m], in the column of the window's cell."""
    middle = 0.5 * (windows.time[1:] + windows.time[:-1])
    inside = np.arange(*np.searchsorted(middle, (edges[0], edges[-1])))
    travel = np.zeros((len(middle), count))
    cell = first + np.searchsorted(edges, middle[inside], side="right") - 1
    travel[inside, cell] = -travelled(windows)[inside, wheel]
    return travel


def _bounded(regression: Regression, conditional: ConditionalFit, offers: Sequence[Term]) -> list[Term]:
    """Return candidates with the bounds of clear ones refined.

    The residual of a clear one with bounds that are wrong by a part of a cell exceeds the noise, and would
    count against it.
    """
    if not offers:
        return []
    significance = np.abs(conditional.z_scores(regression.columns_of(offers)))
    return [
        refine(regression, conditional, offer) if z_score > CLEAR else offer
        for offer, z_score in zip(offers, significance.tolist(), strict=True)
    ]


def _cells(windows: Windows, max_cells: int) -> Array:
    """Return the edges of a recording's cells [s]."""
    start, end = float(windows.time[0]), float(windows.time[-1])
    count = int(np.clip((end - start) / SHORTEST, 1, max_cells))
    return np.linspace(start, end, count + 1)


def _slips(wheel: str, edges: Array, score: Array, gram: Array, tries: int) -> list[Term]:
    """Return candidates of slip in the most significant intervals, none of which overlap.

    Of the K cells between `edges` (K + 1,) [s] are products `score` (K,) of columns with the data, and `gram`
    (K, K). Candidates are chosen among so many tries: any window may begin or end an interval.
    """
    count = len(score)
    score_up_to = np.concatenate(([0.0], np.cumsum(score)))
    area = np.zeros((count + 1, count + 1))
    area[1:, 1:] = gram.cumsum(axis=0).cumsum(axis=1)
    diagonal = np.diagonal(area)
    information = diagonal[None, :] + diagonal[:, None] - area - area.T  # of the cells from row to column
    start, end = np.triu_indices(count + 1, 1)
    z_scores = (score_up_to[end] - score_up_to[start]) / np.sqrt(np.maximum(information[start, end], 1e-12))
    z_scores[2 * (end - start) > count] = 0.0  # a wheel that slips most of the time is a smaller wheel
    candidates = []
    for _ in range(_MAX_INTERVALS):
        at = int(np.argmax(z_scores))
        if z_scores[at] < SEEN:
            break
        interval = (float(edges[start[at]]), float(edges[end[at]]))
        candidates += [
            term(kind.name, wheel, tries, intervals=(interval,))
            for kind in effects_scanned_by("interval", wheel)
        ]
        z_scores[(start < end[at]) & (end > start[at])] = 0.0
    return candidates


def _steps(wheel: str, moments: Array, score: Array, gram: Array, tries: int) -> list[Term]:
    """Return a step of a wheel's radius at the most significant of moments (K,) [s], if one is."""
    after = np.cumsum(score[::-1])[::-1]
    information = np.diagonal(gram[::-1, ::-1].cumsum(axis=0).cumsum(axis=1))[::-1]
    z_scores = np.abs(after) / np.sqrt(np.maximum(information, 1e-12))
    z_scores[0] = 0.0  # a radius that differs from the beginning on is no step
    at = int(np.argmax(z_scores))
    if z_scores[at] < SEEN:
        return []
    time = float(moments[at])
    return [term(kind.name, wheel, tries, time=time) for kind in effects_scanned_by("step", wheel)]


def _losses(regression: Regression, conditionals: Sequence[ConditionalFit]) -> list[Term]:
    """Return speeds above which a wheel's counts are lost."""
    scans, losses = [], []
    blocks = [windows.signals.block for windows in regression.windows]
    for number, wheel in enumerate(regression.windows[0].signals.wheels):
        speeds = [np.abs(block.speed[:, number]) for block in blocks]
        limits = np.quantile(np.concatenate(speeds), np.linspace(0.02, 0.98, _LIMITS))
        travel = [
            np.add.reduceat(
                np.where(speed[:, None] > limits, block.travel[:, number, None], 0.0), windows.ends[:-1]
            )
            for speed, block, windows in zip(speeds, blocks, regression.windows, strict=True)
        ]
        scans.append((wheel, limits, regression.whiten_travel(number, travel)))
    for conditional in conditionals:
        for wheel, limits, columns in scans:
            z_scores = conditional.z_scores(columns)
            at = int(np.argmax(z_scores))
            if z_scores[at] > SEEN and limits[at] > 0.0:
                above = round(float(limits[at]), 4)
                for kind in effects_scanned_by("threshold", wheel):
                    offer = term(kind.name, wheel, len(limits), above=above)
                    losses += _bounded(regression, conditional, [offer])
    return losses


def _harmonics(regression: Regression, conditionals: Sequence[ConditionalFit]) -> list[Term]:
    """Return the two most significant harmonics of each wheel's turn in its travel."""
    scans, harmonics = [], []
    for number, wheel in enumerate(regression.windows[0].signals.wheels):
        travel = []
        for windows in regression.windows:
            angle = windows.at_ends(windows.signals.block.angle[:, number])
            phase = np.outer(angle, np.repeat(ORDERS, 2))
            quarter = np.tile([0.0, 0.5 * np.pi], len(ORDERS))
            travel.append(np.diff(np.cos(phase + quarter), axis=0))
        scans.append((wheel, regression.whiten_travel(number, travel)))
    for conditional in conditionals:
        for wheel, columns in scans:
            chi_square = (conditional.z_scores(columns).reshape(len(ORDERS), 2) ** 2).sum(axis=1)
            harmonics += [
                term(kind.name, wheel, len(ORDERS), order=float(ORDERS[at]))
                for kind in effects_scanned_by("order", wheel)
                for at in np.argsort(-chi_square)[:2]
                if chi_square[at] > SEEN**2
            ]
    return harmonics


def merged(known: Sequence[Term], new: Sequence[Term]) -> list[Term]:
    """Return the new candidates that are neither among the known ones nor repeated."""
    seen, fresh = [(candidate.key, candidate.fixed, candidate.size) for candidate in known], []
    for candidate in new:
        identity = candidate.key, candidate.fixed, candidate.size
        if identity not in seen:
            seen.append(identity)
            fresh.append(candidate)
    return fresh


def travelled(windows: Windows) -> Array:
    """Return the travel of each wheel in each window, `(M, W)` [m]."""
    return np.asarray(np.add.reduceat(windows.signals.block.travel, windows.ends[:-1], axis=0))
