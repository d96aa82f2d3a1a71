"""`triage`: a quick test for any mismatch between recordings and simulation, and where it is.

One candidate for each effect and component, and the most significant moments, are each compared with no
effect by the test of the diagnosis: the smaller of Bayes factor and gain on held-out data, with the prior
odds. Under the null hypothesis a small amount of every effect, and slow variations, are integrated out. The
prior odds of the effects declare the rate of false alarms on healthy robots. Recordings are thinned, noise
levels are estimated coarsely, and nothing is searched or fitted.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from threadpoolctl import threadpool_limits

from omnimate.effects import effects_scanned_by
from omnimate.effects.words import component_in_words
from omnimate.mismatch.answer.doubts import SUREST
from omnimate.mismatch.answer.rivals import POSSIBLE
from omnimate.mismatch.answer.unseen import blind, unseen_in_words
from omnimate.mismatch.answer.where import where_of
from omnimate.mismatch.candidates.pushes import push
from omnimate.mismatch.candidates.regression import Regression
from omnimate.mismatch.candidates.terms import smooth_terms, term
from omnimate.mismatch.description.far_off import far_off
from omnimate.mismatch.description.first_look import first_look
from omnimate.mismatch.diagnosis import ASSERTED, Alternative, Where, as_plain
from omnimate.mismatch.evidence.search import ranked_candidates
from omnimate.mismatch.investigate import (
    posterior_with_background,
    startup_nuisances,
    whiten_with_estimated_noise,
)
from omnimate.mismatch.noise.levels import DEFAULT_LEVELS
from omnimate.mismatch.recording.folds import SHORTEST
from omnimate.mismatch.recording.signals import WINDOW, signals_of
from omnimate.mismatch.recording.validate import check, too_little
from omnimate.mismatch.recording.windows import windows_of
from omnimate.mismatch.scans.disturbances import power
from omnimate.mismatch.scans.events import SEEN, lost_travel_z_scores, spans

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.mismatch.candidates.terms import Term
    from omnimate.mismatch.diagnosis import Key, Verdict
    from omnimate.mismatch.evidence.conditional_fit import Judgement
    from omnimate.mismatch.evidence.posterior import Posterior
    from omnimate.mismatch.recording.signals import Signals
    from omnimate.vehicle.recording import Recording
    from omnimate.vehicle.se2 import Array

Interval = tuple[float, float]

SAMPLES = 3  # in a window of a thinned recording: enough for an acceleration and a reversal
PUSH_CHI_SQUARE = 16.27  # with three degrees of freedom, noise exceeds it in one window of a thousand
JUDGED = 8  # candidates of the largest evidence that are judged in full
MAX_CELLS = 16  # of a recording, of which intervals are composed
# [standard deviations] root mean square of the residual that is a mismatch, whether or not a candidate
# explains it; with the estimated noise levels it is about one.
MAX_RESIDUAL = 2.0
EXPLAINED_FRACTION = 0.5  # of what a candidate explains that the reported blocks contain
MAX_SAID = 5  # intervals that the sentence names; all are in `where`
MAX_BLOCK_FRACTION = 0.25  # of all blocks; in more, it acts all along the drive


@dataclass(frozen=True, slots=True)
class Triage:
    """Triage of recordings of one robot."""

    verdict: Verdict  # agreement, mismatch or insufficient
    says: str  # the verdict in a sentence; for "insufficient", what to record
    robot: str  # name of the vehicle
    recordings: tuple[str, ...]  # names of the recordings, in order
    probability: float = 0.0  # probability of any mismatch; from 0.5 on the verdict is a mismatch
    # the signals on which it shows, and the blocks of time that hold half of it; no interval where it acts
    # all along the drive
    where: Where = field(default_factory=Where)
    closest: tuple[Alternative, ...] = ()  # that explain it best alone, the most probable first
    heldout: float = 0.0  # gain in log density of held-out data by the best of them [nat]

    def as_json(self) -> dict[str, Any]:
        """Return the JSON object."""
        answer: dict[str, Any] = as_plain(self)
        return answer


def triage(recordings: Sequence[Recording]) -> Triage:
    """Return whether recordings of one robot show physics that its simulation leaves out, and where.

    Args:
        recordings: Recordings of one robot, all with the same `vehicle.toml`.

    Raises:
        RecordingError: Recordings of two robots, a clock that jumps, a channel or poses that do not fit.
    """
    check(recordings)
    with threadpool_limits(1, user_api="blas"):  # as in `diagnose`
        return _answer(recordings)


def _answer(recordings: Sequence[Recording]) -> Triage:
    robot, names = recordings[0].vehicle.name, tuple(recording.source for recording in recordings)
    reason = too_little(recordings)
    if reason:
        return Triage("insufficient", reason, robot, names)
    look = first_look(recordings)
    if look is not None:
        wrong = far_off(recordings, look)
        closest = tuple(
            Alternative(*finding.key, probability=finding.probability) for finding in wrong.findings
        )
        return Triage("mismatch", wrong.says, robot, names, SUREST, wrong.findings[0].where, closest)
    posterior = _candidates([signals_of(thinned(recording)) for recording in recordings])
    conditional = posterior.given(())
    offers = ranked_candidates(posterior, conditional)[:JUDGED]
    judged = list(zip(offers, conditional.judge_all(offers), strict=True))
    probability, closest = _shares(posterior, judged)
    if float((conditional.residual**2).mean()) > MAX_RESIDUAL**2:
        probability = SUREST
    if probability >= ASSERTED:
        part, gain = conditional.residual, 0.0
        if closest:
            best, judgement = max(judged, key=lambda pair: pair[1].log_odds)
            columns = conditional.residual_columns(posterior.candidates.columns(best))
            part, gain = columns @ judgement.coefficients, judgement.heldout_gain
        fall = conditional.residual**2 - (conditional.residual - part) ** 2
        intervals = _intervals(posterior.regression, fall)
        seen = where_of(posterior.regression, part, intervals, "" if intervals else "all along the drive")
        says = _says(seen, closest)
        return Triage("mismatch", says, robot, names, probability, seen, closest, gain)
    unseen = blind(posterior)
    if unseen:
        return Triage("insufficient", unseen_in_words(unseen)[0], robot, names, probability)
    says = "Nothing stands out beyond the noise of sensors and floor."
    return Triage("agreement", says, robot, names, probability)


def thinned(recording: Recording) -> Recording:
    """Return a recording with about three samples in each window, each the most complete of its neighbours.

    Counters are absolute, so that no travel is lost.
    """
    time = recording.time
    if len(time) < 2:
        return recording
    few = int(WINDOW / SAMPLES / float(np.median(np.diff(time))) * (1.0 + 1e-6))
    if few < 2:
        return recording
    kept = len(time) // few * few
    read = recording.present[:kept].sum(axis=1).reshape(-1, few)
    at = np.arange(0, kept, few) + np.argmax(read, axis=1)
    return replace(
        recording, time=time[at], counts=recording.counts[at], present=recording.present[at], commands=None
    )


def _candidates(signals: Sequence[Signals]) -> Posterior:
    """Return one candidate for each effect and component, and the most significant moments."""
    library: dict[Key, Term] = {}
    for candidate in smooth_terms(signals):
        library.setdefault(candidate.key, candidate)
    regression = Regression([windows_of(recording) for recording in signals], DEFAULT_LEVELS, ())
    offered = startup_nuisances(list(library.values()), signals)
    places = regression.add(offered)
    regression = whiten_with_estimated_noise(regression, roughly=True)
    others = [candidate for candidate in library.values() if candidate not in offered]
    places += regression.add(others, keep=False)
    posterior = posterior_with_background(regression, [*offered, *others], places)
    events = [*_moments(posterior), *spans(regression, [posterior.given(())], MAX_CELLS)]
    if not events:
        return posterior
    return posterior.with_more(events, regression.add(events, keep=False))


def _moments(posterior: Posterior) -> list[Term]:
    """Return the most significant bump under each wheel and push of each truck, if they are significant."""
    regression, candidates = posterior.regression, []
    tries = regression.window_count
    pushes = regression.push_scores(posterior.given(()).residual)
    for windows, (scores, informations) in zip(regression.windows, pushes, strict=True):
        z_scores = lost_travel_z_scores(windows, scores, informations)
        for number, wheel in enumerate(map(str, windows.signals.wheels)):
            at = int(np.argmax(z_scores[:, number]))
            if z_scores[at, number] > SEEN:
                times = (float(windows.time[at]) + 0.25 * WINDOW,)
                candidates += [
                    term(kind.name, wheel, tries, times=times)
                    for kind in effects_scanned_by("moments", wheel)
                ]
        for number, truck in enumerate(windows.signals.trucks):
            pose = slice(3 * number, 3 * number + 3)
            chi_square = power(scores[:, pose], informations[:, pose, pose])
            at = int(np.argmax(chi_square))
            if chi_square[at] > PUSH_CHI_SQUARE:
                candidates.append(push(truck, float(windows.time[at]), tries))
    return candidates


def _shares(
    posterior: Posterior, judged: Sequence[tuple[int, Judgement]]
) -> tuple[float, tuple[Alternative, ...]]:
    """Return the probability of any mismatch, and the most probable effects.

    Each candidate is compared with no effect: their odds add up to those of any mismatch.
    """
    log_odds: dict[Key, float] = {}
    for candidate, judgement in judged:
        key = posterior.terms[candidate].key
        log_odds[key] = max(log_odds.get(key, -math.inf), judgement.log_odds)
    if not log_odds:
        return 0.0, ()
    largest = max(0.0, *log_odds.values())
    odds = {key: math.exp(value - largest) for key, value in log_odds.items()}
    total = math.exp(-largest) + sum(odds.values())
    order = sorted(odds, key=lambda key: -odds[key])
    closest = [Alternative(*key, probability=min(odds[key] / total, SUREST)) for key in order]
    probable = tuple(effect for effect in closest if effect.probability >= POSSIBLE)
    return min(sum(odds.values()) / total, SUREST), probable


def _says(seen: Where, closest: Sequence[Alternative]) -> str:
    """Return the mismatch in a sentence."""
    times = ", ".join(f"{start:.1f} to {end:.1f} s" for start, end in seen.intervals[:MAX_SAID])
    if len(seen.intervals) > MAX_SAID:
        times += f" and {len(seen.intervals) - MAX_SAID} more times"
    near = " or ".join(
        f"{effect.effect.replace('_', ' ')} of {component_in_words(effect.component)}"
        for effect in closest[:2]
    )
    return (
        f"Something stands out on {', '.join(seen.channels)}, {f'at {times}' if times else seen.regime}. "
        f"{f'It looks most like {near}' if near else 'No single effect comes near it'}; "
        "run the whole diagnosis."
    )


def _intervals(regression: Regression, by_row: Array) -> tuple[Interval, ...]:
    """Return the fewest blocks with half of the decrease of chi-square (V,); none where they are many."""
    blocks: list[Interval] = []
    owner: list[int] = []
    decrease: list[float] = []
    time = regression.time
    for number, windows in enumerate(regression.windows):
        start, end = float(windows.time[0]), float(windows.time[-1])
        edges = np.linspace(start, end, max(1, round((end - start) / SHORTEST)) + 1)
        rows = regression.rows_of(number)
        block = np.clip(np.searchsorted(edges, time[rows], side="right") - 1, 0, len(edges) - 2)
        decrease += np.bincount(block, weights=by_row[rows], minlength=len(edges) - 1).tolist()
        blocks += itertools.pairwise(edges.tolist())
        owner += [number] * (len(edges) - 1)
    order = np.argsort(decrease)[::-1]
    total = np.cumsum(np.asarray(decrease)[order])
    count = int(np.searchsorted(total, EXPLAINED_FRACTION * sum(decrease))) + 1
    if count > MAX_BLOCK_FRACTION * len(blocks):
        return ()
    chosen = np.sort(order[:count])
    apart = (np.diff(chosen) > 1) | (np.diff(np.array(owner)[chosen]) > 0)
    stretches = np.split(chosen, np.flatnonzero(apart) + 1)
    return tuple((blocks[stretch[0]][0], blocks[stretch[-1]][1]) for stretch in stretches)
