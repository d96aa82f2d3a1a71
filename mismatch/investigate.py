"""The search for what a simulation leaves out of recordings: noise, candidates, sets of them, in rounds."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from omnimate.mismatch.candidates.nuisances import add_nuisances
from omnimate.mismatch.candidates.terms import UNKNOWN, is_near, mounted_terms, smooth_terms, term
from omnimate.mismatch.candidates.unknown import add_unknown
from omnimate.mismatch.evidence.candidates import Candidates
from omnimate.mismatch.evidence.posterior import Posterior
from omnimate.mismatch.evidence.search import search
from omnimate.mismatch.fit import Fitted, fitted
from omnimate.mismatch.learn.law_terms import learned
from omnimate.mismatch.noise.levels import DEFAULT_LEVELS, FINE, ROUGH, WAVES, estimate_noise
from omnimate.mismatch.recording.signals import signals_of
from omnimate.mismatch.scans.disturbances import freed
from omnimate.mismatch.scans.events import events, merged, push_terms
from omnimate.mismatch.scans.nonlinear import settled
from omnimate.mismatch.scans.obstacles import OBSTACLE, no_obstacles, obstacles

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from omnimate.mismatch.candidates.regression import Regression
    from omnimate.mismatch.candidates.terms import Term
    from omnimate.mismatch.fit import Acting
    from omnimate.mismatch.noise.levels import NoiseLevels
    from omnimate.mismatch.recording.signals import Signals
    from omnimate.vehicle.recording import Recording
    from omnimate.vehicle.se2 import Array

    Progress = Callable[[int, int, str], None]

# Noise is not quite white, and a robot steers against its errors: both make an innovation resemble those of
# the last two seconds, and what goes with the rate of a channel resemble a delay of it (Forssell & Ljung,
# Automatica 1999: identification in closed loop with a wrong noise model). So many windows, and weights.
ECHOES, ECHO = 8, 0.15
UNKNOWN_OFFERED = 8  # errors without a name that are held against the named ones: the best of all by far
FAR = 3.0  # standard deviations beyond which two estimates of a size contradict each other
NONE = 1e-6  # declared sizes, below which an effect is none at all
ROUNDS = 5  # of candidates, search, fit and noise, if the answer still changes
STEPS = 2 * ROUNDS + 2  # that a progress bar sees


@dataclass(frozen=True, slots=True)
class Investigation:
    """What the search came to.

    Attributes:
        signals: Of each recording, about the nominal robot.
        posterior: The candidates, about the best set's effects.
        members: Numbers of the best set's candidates; all bumps of one wheel are one of them.
        named: Those of them that are effects of the fit, in its order; laws come after them.
        fit: The best set's effects.
    """

    signals: tuple[Signals, ...]
    posterior: Posterior
    members: tuple[int, ...]
    named: tuple[int, ...]
    fit: Fitted


def investigate(
    recordings: Sequence[Recording],
    without: Iterable[str] = (),
    progress: Progress = lambda _done, _all, _doing: None,
) -> Investigation:
    """Return the set of effects that explains recordings best.

    Args:
        recordings: Of one robot.
        without: Effects to leave out of the library.
        progress: Is told how much is done, of how much, and what is being done.
    """
    progress(0, STEPS, "noise levels of the nominal robot")
    signals = tuple(signals_of(single) for single in recordings)
    left_out = set(without)
    library = [single for single in smooth_terms(signals) if single.effect not in left_out]
    nothing = fitted(signals, DEFAULT_LEVELS, (), ())
    nothing.regression.add(usual(library, signals))
    noise = noise_beside(nothing.regression)
    met = (no_obstacles if left_out & {OBSTACLE.name} else obstacles)(nothing.regression)
    noise = nothing.regression.noise if met.terms else noise
    shaken = met.pushes
    fit = fitted(signals, noise, met.terms, met.values, 1, nothing, shaken)
    names: set[tuple[tuple[str, str], int]] = set()
    for turn in range(ROUNDS):
        progress(2 * turn + 1, STEPS, "comparing sets of effects")
        posterior, start = _posterior(fit, library, left_out, nameless=turn > 0)
        members = search(posterior, start if turn > 0 else (*start, *_calibration(posterior, fit)))
        progress(2 * turn + 2, STEPS, "fitting effects and noise")
        terms, values = _settled(posterior, members)
        fit = fitted(signals, noise, terms, values, start=fit, pushes=shaken)
        noise = _noise_about(fit)
        fit = fitted(signals, noise, fit.chosen.terms, fit.chosen.values, 1, fit, shaken)
        before, names = names, {(single.key, len(single.fixed.get("times", ()))) for single in terms}
        if turn > 0 and names == before:
            break
    # what is left now and is no noise has no candidate: it counts as noise, and moments that stand out tell
    # nothing, lest something that lasts be told for them
    noise, pushes = _happened(fit)
    pushes = [own + more for own, more in zip(shaken, pushes, strict=True)]
    fit = fitted(signals, noise, fit.chosen.terms, fit.chosen.values, 1, fit, pushes)
    progress(2 * ROUNDS + 1, STEPS, "holding the answer against its rivals")
    posterior, start = _posterior(fit, library, left_out, scan=False)
    if UNKNOWN not in left_out:
        posterior = _with_unknown(posterior, start)
    return _final(signals, noise, shaken, pushes, posterior, start, fit)


def _final(
    signals: tuple[Signals, ...],
    noise: NoiseLevels,
    shaken: Sequence[Array],
    pushes: Sequence[Array],
    posterior: Posterior,
    start: tuple[int, ...],
    fit: Fitted,
) -> Investigation:
    """Return what stands when the last set of a search is fitted beside everything that is calibrated.

    What does not is no candidate any more, and the search goes on without it.
    """
    known = dict(zip(start, zip(fit.chosen.terms, fit.chosen.values, strict=True), strict=True))
    members: tuple[int, ...] = start
    while True:
        members = search(posterior, members)
        named = tuple(single for single in members if posterior.terms[single].probes)
        terms, values = [], []
        for single in named:
            sizes = posterior.given(set(members) - {single}).judge(single).coefficients
            own, size = known.get(single, (posterior.terms[single], sizes))
            terms.append(own)
            values.append(size)
        conditional = posterior.given(named)
        for single in set(members) - set(named):
            for law in learned(posterior, conditional, posterior.terms[single]):
                terms.append(law)
                values.append(np.ones(len(law.probes)))
        fit = fitted(signals, noise, terms, values, 1, fit, pushes)
        fallen = [
            single
            for number, single in enumerate(named)
            if not _stands(posterior.terms[single], fit.chosen, number)
        ]
        if not fallen:
            # what happened tells nothing of which effects there are, and yet of how large they are
            whole = fitted(signals, noise, terms, values, 1, fit, shaken)
            fit = whole if _agrees(whole.chosen, fit.chosen) else fit
            return Investigation(signals, posterior, members, named, fit)
        posterior = posterior.without(fallen)
        members = tuple(single for single in members if single not in fallen)


def _stands(single: Term, chosen: Acting, number: int) -> bool:
    """Say whether an effect of a fit may still be there beside all others and the calibration.

    No prior gives a size that is z standard deviations from none a log Bayes factor beyond z^2/2 (Edwards,
    Lindman & Savage, Psychological Review 1963); what makes no sense below zero may have come to zero; and
    nobody believes in what is absurdly large.
    """
    values, covariance = chosen.values[number], chosen.covariances()[number]
    if not NONE < float(np.abs(values).max()) <= single.largest:
        return False
    return single.odds + 0.5 * float(values @ np.linalg.solve(covariance, values)) > 0.0


def _agrees(whole: Acting, quiet: Acting) -> bool:
    """Say whether effects are as large where something happened as they are in the rest, to three sigma."""
    return all(
        bool(np.all(np.abs(size - usual) < FAR * np.sqrt(np.diagonal(covariance))))
        for size, usual, covariance in zip(whole.values, quiet.values, quiet.covariances(), strict=True)
    )


def _calibration(posterior: Posterior, fit: Fitted) -> tuple[int, ...]:
    """Return the candidates that are calibrated in any case: from these a search begins."""
    keys = {single.key for single in fit.calibrated.terms}
    return tuple(number for number, single in enumerate(posterior.terms) if single.key in keys)


def _posterior(
    fit: Fitted, library: Sequence[Term], left_out: set[str], *, scan: bool = True, nameless: bool = True
) -> tuple[Posterior, tuple[int, ...]]:
    """Return the candidates about a fit's effects, and the numbers of those effects among them.

    Where nothing is scanned, pushes are offered all the same: an event that does not stand leaves them.
    """
    regression = fit.regression
    terms, places = list(fit.chosen.terms), list(fit.chosen.places)
    start = tuple(range(len(terms)))
    for effect, place, values in zip(fit.chosen.effects, places, fit.chosen.values, strict=True):
        if len(values) == 1 and abs(values[0]) > NONE:
            regression.take_secant(place, effect, float(values[0]))
    offered = merged(terms, library)
    places += regression.add(offered, keep=False)
    terms += offered
    posterior = with_everyday(regression, terms, places, fit.part)
    conditionals = [posterior.given(start), *([posterior.given(())] if start else [])]
    local = (
        events(regression, conditionals, nameless=nameless)
        if scan
        else push_terms(regression, [regression.shocks(conditional.residual) for conditional in conditionals])
    )
    more = [single for single in merged(terms, local) if single.effect not in left_out]
    return posterior.with_more(more, regression.add(more, keep=False)), start


def with_everyday(
    regression: Regression, terms: Sequence[Term], places: Sequence[slice], shift: Array
) -> Posterior:
    """Return candidates beside what every robot has a little of, whose columns are added.

    The data are then those of the nominal robot.

    Args:
        regression: With the candidates' columns.
        terms: The candidates.
        places: Where each one's columns are.
        shift: What of the data's column the base of the regression has taken away, `(V,)`.
    """
    numbers, sizes, names = [], [], {}
    for single, place in zip(terms, places, strict=True):
        size = _everyday(single)
        for column in range(place.start, place.stop) if size else ():
            numbers.append(column)
            sizes.append(size)
            names[column] = single.key
    mounted = mounted_terms([windows.signals for windows in regression.windows])
    setup = [
        column for place in regression.add(mounted, keep=False) for column in range(place.start, place.stop)
    ]
    for column in (*setup, *add_nuisances(regression)):
        numbers.append(column)
        sizes.append(1.0)
        names[column] = "nuisance", "any"
    echoes = regression.echoes(ECHOES)
    for column in range(regression.white.shape[1], regression.white.shape[1] + echoes.shape[1]):
        numbers.append(column)
        sizes.append(ECHO)
        names[column] = "noise", "linkage"
    regression.white = np.hstack([regression.white, echoes])
    regression.white[:, 0] += shift
    everyday = np.array(numbers, np.int64), np.array(sizes)
    return Posterior(Candidates(regression, list(terms), list(places), everyday, names))


def _with_unknown(posterior: Posterior, start: Sequence[int]) -> Posterior:
    """Return the candidates with those errors without a name that may be worth most beside a set or alone."""
    regression = posterior.regression
    first = regression.white.shape[1]
    offered, where = add_unknown(regression)
    regression.white, added = np.hsplit(regression.white, [first])
    widths = [at.stop - at.start for at in where]
    best: list[int] = []
    for conditional in (posterior.given(start), *([posterior.given(())] if start else [])):
        worth = np.array([single.odds for single in offered]) + conditional.log_bayes_factors(added, widths)
        order = np.argsort(-worth, kind="stable").tolist()
        best += [at for at in order[:UNKNOWN_OFFERED] if at not in best]
    columns = [column - first for at in best for column in range(where[at].start, where[at].stop)]
    edges = first + np.cumsum([0, *(widths[at] for at in best)])
    regression.white = np.hstack([regression.white, added[:, columns]])
    places = [slice(int(start), int(end)) for start, end in itertools.pairwise(edges)]
    return posterior.with_more([offered[at] for at in best], places)


def _everyday(single: Term) -> float:
    """Return how much of a candidate every robot has, in declared sizes."""
    return single.background if single.size == 1.0 else 0.0


def _settled(posterior: Posterior, members: Sequence[int]) -> tuple[list[Term], list[np.ndarray]]:
    """Return a set's candidates with their moments where they are seen best, all of a wheel in one."""
    regression = posterior.regression
    chosen, values = {}, {}
    for single in members:
        conditional = posterior.given(set(members) - {single})
        found = posterior.terms[single]
        if len(found.probes) == 1 and len(found.fixed.get("times", ())) < 2:
            found = settled(regression, conditional, found)
        chosen[single] = found
        values[single] = conditional.judge(single).coefficients
    terms, sizes = [], []
    for key in dict.fromkeys(found.key for found in chosen.values()):
        same = [single for single in chosen if chosen[single].key == key]
        if (
            chosen[same[0]].scan == "moments"
            and len(same) > 1
            and all(chosen[single].held is None for single in same)
        ):
            pairs = sorted(
                (time, float(value))
                for single in same
                for time, value in zip(chosen[single].fixed["times"], values[single], strict=True)
            )
            tries = sum(len(windows.ends) for windows in regression.windows)
            terms.append(term(*key, tries, times=tuple(time for time, _ in pairs)))
            sizes.append(np.array([value for _, value in pairs]))
        else:
            terms += [chosen[single] for single in same]
            sizes += [values[single] for single in same]
    return terms, sizes


def usual(library: Sequence[Term], signals: Sequence[Signals]) -> list[Term]:
    """Return what may be wrong with any robot, and is a nuisance while nothing is known yet."""
    seen = any(single.poses is not None for single in signals)
    when = {"always", "with poses"} if seen else {"always"}
    return [single for single in library if single.kind.startup_nuisance in when and single.size == 1.0]


def noise_beside(regression: Regression, *, roughly: bool = False) -> NoiseLevels:
    """Return the levels of noise of a robot of which nothing is known yet, and whiten with them.

    Windows in which something happened do not count; but first they all do, as what happened is what stands
    out of all the noise that there is.

    Args:
        regression: Of the nominal robot, with the columns of nuisances.
        roughly: Whether one length of waves and levels near the likeliest ones will do.
    """
    noise = regression.noise
    waves, tolerance = ((noise.wave,), ROUGH) if roughly else (WAVES, FINE)
    if not roughly:
        noise = estimate_noise(regression.windows, regression.raw, noise, (noise.wave,))
        regression.whiten(noise)
    windows, _count = freed(regression, regression.without(regression.sizes()))
    noise = estimate_noise(windows, regression.raw, noise, waves, tolerance)
    regression.whiten(noise)
    return noise


def _noise_about(fit: Fitted) -> NoiseLevels:
    """Return the levels of noise about a set of effects; windows in which something happened do not count."""
    regression = fit.regression
    windows, _count = freed(regression, regression.white[:, 0])
    return estimate_noise(windows, regression.raw, regression.noise, (regression.noise.wave,))


def _happened(fit: Fitted) -> tuple[NoiseLevels, list[Array]]:
    """Return the levels of noise by which all windows count, and what trucks are pushed by in some.

    The pushes are process covariances `(M, n, n)` of each recording, where something happened that has no
    candidate. What the law of a candidate leaves is no noise.
    """
    regression = fit.regression
    windows, _count = freed(regression, regression.white[:, 0])
    stretches = [stretch for single in fit.chosen.terms for stretch in single.active_intervals]
    counting, pushes = [], []
    for own, usual in zip(windows, regression.windows, strict=True):
        near = is_near(usual.time[:-1], stretches)[:, None, None]
        push = own.rounding - usual.rounding
        pushes.append(np.where(near, 0.0, push))
        counting.append(replace(usual, rounding=usual.rounding + np.where(near, push, 0.0)))
    noise = estimate_noise(counting, regression.raw, regression.noise, (regression.noise.wave,))
    return noise, pushes
