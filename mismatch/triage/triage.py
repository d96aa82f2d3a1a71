"""`triage`: the first question of a diagnosis, asked once: is anything there at all, and where?

One candidate for each effect and component, and the strongest moments, are each held against nothing, by the
same test as in the diagnosis: the smaller of the Bayes factor and of what is earned on unseen data, and the
prior odds. The null is the everyday model: a little of every effect, and what moves slowly, are integrated
out. The prior odds of the effects declare how often a healthy robot is called one that is not.
Recordings are thinned, levels of noise are found roughly, and nothing is searched or fitted.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from omnimate.effects import effects_scanned_by
from omnimate.effects.words import component_in_words
from omnimate.mismatch.answer.findings import SUREST, blind, unseen_in_words
from omnimate.mismatch.answer.rivals import POSSIBLE
from omnimate.mismatch.candidates.pushes import push
from omnimate.mismatch.candidates.regression import Regression
from omnimate.mismatch.candidates.terms import smooth_terms, term
from omnimate.mismatch.description.far_off import far_off
from omnimate.mismatch.description.first_look import first_look
from omnimate.mismatch.diagnosis import ASSERTED, Alternative
from omnimate.mismatch.evidence.search import ranked_candidates
from omnimate.mismatch.investigate import (
    posterior_with_background,
    startup_nuisances,
    whiten_with_estimated_noise,
)
from omnimate.mismatch.noise.levels import DEFAULT_LEVELS
from omnimate.mismatch.recording.signals import WINDOW, signals_of
from omnimate.mismatch.recording.validate import check, too_little
from omnimate.mismatch.recording.windows import windows_of
from omnimate.mismatch.scans.disturbances import power
from omnimate.mismatch.scans.events import SEEN, lost_travel_z_scores, spans
from omnimate.mismatch.triage.answer import Triage
from omnimate.mismatch.triage.blocks import where
from omnimate.mismatch.triage.thinning import thinned

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.mismatch.candidates.terms import Term
    from omnimate.mismatch.diagnosis import Key, Where
    from omnimate.mismatch.evidence.conditional_fit import Judgement
    from omnimate.mismatch.evidence.posterior import Posterior
    from omnimate.mismatch.recording.signals import Signals
    from omnimate.vehicle.recording import Recording


HAPPENED = 16.27  # chi-square with three degrees of freedom that noise exceeds in one window of a thousand
JUDGED = 8  # candidates of the largest evidence that are judged in full
COARSE = 16  # cells of a recording, of which stretches are made
# Times the noise, from which on what is left is no noise, whether or not a candidate comes near: the levels
# are the likeliest ones, about which noise has the size of one.
FAR = 2.0


def triage(recordings: Sequence[Recording]) -> Triage:
    """Return whether recordings of one robot show anything that its simulation leaves out, and where.

    Args:
        recordings: Of one robot, all with the same `vehicle.toml`.

    Raises:
        RecordingError: Recordings of two robots, a clock that jumps, a channel or poses that do not fit.
    """
    check(recordings)
    robot, names = recordings[0].vehicle.name, tuple(single.source for single in recordings)
    reason = too_little(recordings)
    if reason:
        return Triage("insufficient", reason, robot, names)
    look = first_look(recordings)
    if look is not None:
        wrong = far_off(recordings, look)
        closest = tuple(Alternative(*one.key, probability=one.probability) for one in wrong.findings)
        return Triage("mismatch", wrong.says, robot, names, SUREST, wrong.findings[0].where, closest)
    posterior = _candidates([signals_of(thinned(single)) for single in recordings])
    conditional = posterior.given(())
    offers = ranked_candidates(posterior, conditional)[:JUDGED]
    judged = list(zip(offers, conditional.judge_all(offers), strict=True))
    probability, closest = _shares(posterior, judged)
    if float((conditional.residual**2).mean()) > FAR**2:
        probability = SUREST
    if probability >= ASSERTED:
        part, gain = conditional.residual, 0.0
        if closest:
            best, its = max(judged, key=lambda pair: pair[1].log_odds)
            part, gain = (
                conditional.residual_columns(posterior.candidates.columns(best)) @ its.coefficients,
                its.heldout_gain,
            )
        seen = where(posterior.regression, conditional.residual, part)
        says = _says(seen, closest)
        return Triage("mismatch", says, robot, names, probability, seen, closest, gain)
    unseen = blind(posterior)
    if unseen:
        return Triage("insufficient", unseen_in_words(unseen)[0], robot, names, probability)
    says = "Nothing stands out beyond the noise of sensors and floor."
    return Triage("agreement", says, robot, names, probability)


def _candidates(signals: Sequence[Signals]) -> Posterior:
    """Return one candidate for each effect and component, and the strongest moments."""
    library: dict[Key, Term] = {}
    for single in smooth_terms(signals):
        library.setdefault(single.key, single)
    regression = Regression([windows_of(single) for single in signals], DEFAULT_LEVELS, ())
    offered = startup_nuisances(list(library.values()), signals)
    places = regression.add(offered)
    regression = whiten_with_estimated_noise(regression, roughly=True)
    others = [single for single in library.values() if single not in offered]
    places += regression.add(others, keep=False)
    shift = np.zeros(len(regression.white))
    posterior = posterior_with_background(regression, [*offered, *others], places, shift)
    events = [*_moments(posterior), *spans(regression, [posterior.given(())], COARSE)]
    if not events:
        return posterior
    return posterior.with_more(events, regression.add(events, keep=False))


def _moments(posterior: Posterior) -> list[Term]:
    """Return the strongest bump under each wheel and push of each truck, where they stand out."""
    regression, found = posterior.regression, []
    tries = sum(len(windows.ends) for windows in regression.windows)
    pushes = regression.push_scores(posterior.given(()).residual)
    for windows, (scores, informations) in zip(regression.windows, pushes, strict=True):
        sigmas = lost_travel_z_scores(windows, scores, informations)
        for number, wheel in enumerate(map(str, windows.signals.recording.vehicle.wheels)):
            at = int(np.argmax(sigmas[:, number]))
            if sigmas[at, number] > SEEN:
                times = (float(windows.time[at]) + 0.25 * WINDOW,)
                found += [
                    term(kind.name, wheel, tries, times=times)
                    for kind in effects_scanned_by("moments", wheel)
                ]
        for number, truck in enumerate(windows.signals.trucks):
            own = slice(3 * number, 3 * number + 3)
            chi_square = power(scores[:, own], informations[:, own, own])
            at = int(np.argmax(chi_square))
            if chi_square[at] > HAPPENED:
                found.append(push(truck, float(windows.time[at]), tries))
    return found


def _shares(
    posterior: Posterior, judged: Sequence[tuple[int, Judgement]]
) -> tuple[float, tuple[Alternative, ...]]:
    """Return the probability that anything is there, and the shares of the effects that come closest.

    Each candidate is held against nothing: their odds add up to those of anything at all.
    """
    worths: dict[Key, float] = {}
    for single, its in judged:
        key = posterior.terms[single].key
        worths[key] = max(worths.get(key, -math.inf), its.log_odds)
    if not worths:
        return 0.0, ()
    top = max(0.0, *worths.values())
    odds = {key: math.exp(worth - top) for key, worth in worths.items()}
    whole = math.exp(-top) + sum(odds.values())
    order = sorted(odds, key=lambda key: -odds[key])
    closest = (Alternative(*key, probability=min(odds[key] / whole, SUREST)) for key in order)
    return min(sum(odds.values()) / whole, SUREST), tuple(
        one for one in closest if one.probability >= POSSIBLE
    )


def _says(seen: Where, closest: Sequence[Alternative]) -> str:
    """Return in a sentence what stands out."""
    times = ", ".join(f"{start:.1f} to {end:.1f} s" for start, end in seen.intervals)
    near = " or ".join(
        f"{one.effect.replace('_', ' ')} of {component_in_words(one.component)}" for one in closest[:2]
    )
    return (
        f"Something stands out on {', '.join(seen.channels)}, {f'at {times}' if times else seen.regime}. "
        f"{f'It looks most like {near}' if near else 'No single effect comes near it'}; "
        "run the whole diagnosis."
    )
