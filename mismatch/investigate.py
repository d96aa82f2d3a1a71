"""Search for the effects that a simulation leaves out: noise, candidates and sets of them, in rounds."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from omnimate.effects.errors import EffectError
from omnimate.mismatch.candidates.nuisances import add_nuisances
from omnimate.mismatch.candidates.regression import slices_of
from omnimate.mismatch.candidates.terms import UNKNOWN, is_near, mounted_terms, smooth_terms, term
from omnimate.mismatch.candidates.unknown import unknown_errors
from omnimate.mismatch.evidence.candidates import Candidates
from omnimate.mismatch.evidence.posterior import Posterior
from omnimate.mismatch.evidence.search import search
from omnimate.mismatch.fit import NEGLIGIBLE_SIZE, Fitted, fitted
from omnimate.mismatch.heldout import predicts_better
from omnimate.mismatch.learn.law_terms import learned
from omnimate.mismatch.noise.levels import DEFAULT_LEVELS, FINE, ROUGH, WAVES, estimate_noise
from omnimate.mismatch.recording.signals import signals_of
from omnimate.mismatch.scans.disturbances import inflate_disturbed_windows
from omnimate.mismatch.scans.events import events, merged, push_terms
from omnimate.mismatch.scans.nonlinear import refine
from omnimate.mismatch.scans.obstacles import OBSTACLE, find_obstacles, no_obstacles
from omnimate.vehicle.errors import RecordingError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from omnimate.mismatch.candidates.regression import Regression
    from omnimate.mismatch.candidates.terms import Term
    from omnimate.mismatch.candidates.unknown import UnknownErrors
    from omnimate.mismatch.diagnosis import Key
    from omnimate.mismatch.fit import Acting
    from omnimate.mismatch.noise.levels import NoiseLevels
    from omnimate.mismatch.recording.signals import Signals
    from omnimate.vehicle.recording import Recording
    from omnimate.vehicle.se2 import Array

    Progress = Callable[[int, int, str], None]

# Regressors for noise that is not quite white and for a robot that steers against its errors: the data of the
# last two seconds. Without them, correlation with the rate of a channel resembles a delay of it (Forssell &
# Ljung, Automatica 1999: identification in closed loop with a wrong noise model).
LAGS, LAG_SIZE = 8, 0.15  # [windows], prior standard deviation of a coefficient
UNKNOWN_OFFERED = 8  # unknown errors, the likeliest, that are compared with the effects of the library
MAX_DISAGREEMENT = 3.0  # standard deviations beyond which two estimates of a size contradict each other
ROUNDS = 5  # of candidates, search, fit and noise, if the answer still changes
PROGRESS_STEPS = 2 * ROUNDS + 2
BUDGET, BUDGET_SAMPLES = 20.0, 20_000  # [s] of processor time for recordings of so many samples, or fewer
MIN_ROUNDS = 2  # that are made whatever they take: the first has no unknown errors in it


@dataclass(frozen=True, slots=True)
class Investigation:
    """Result of the search."""

    signals: tuple[Signals, ...]  # of each recording, about the nominal robot
    posterior: Posterior  # the candidates, about the best set's effects
    members: tuple[int, ...]  # numbers of the best set's candidates; all bumps of one wheel are one of them
    named: tuple[int, ...]  # those of them that are effects of the fit, in its order; laws come after them
    fit: Fitted  # the best set's effects
    unknown: UnknownErrors  # errors without a name, of which any may be left
    complete: bool = True  # whether it ended because the answer did not change any more


def _nominal(signals: tuple[Signals, ...]) -> Fitted:
    """Return the fit without effects: only what is calibrated in any case, as where the reference is mounted.

    Raises:
        RecordingError: No possible value of these brings poses and wheels together.
    """
    try:
        return fitted(signals, DEFAULT_LEVELS, (), ())
    except EffectError as error:
        raise RecordingError(
            signals[0].recording.source,
            f"its poses do not fit its wheels ({error}); check that x and y are in metres, theta is in "
            "radians, and both are of the same drive",
        ) from error


def investigate(
    recordings: Sequence[Recording],
    without: Iterable[str] = (),
    progress: Progress = lambda _done, _all, _doing: None,
    budget: float | None = None,
) -> Investigation:
    """Return the set of effects that explains recordings best; for the arguments see `diagnose`."""
    progress(0, PROGRESS_STEPS, "noise levels of the nominal robot")
    signals = tuple(signals_of(recording) for recording in recordings)
    excluded = set(without)
    library = [term for term in smooth_terms(signals) if term.effect not in excluded]
    nominal = _nominal(signals)
    regression = nominal.regression.branch()
    regression.add(startup_nuisances(library, signals))
    regression = whiten_with_estimated_noise(regression)
    obstacles = (no_obstacles if excluded & {OBSTACLE.name} else find_obstacles)(regression)
    noise = obstacles.noise
    fit = fitted(signals, noise, obstacles.terms, obstacles.values, 1, nominal, obstacles.disturbances)
    names: set[tuple[tuple[str, str], int]] = set()
    complete, started = True, time.process_time()
    if budget is None:
        budget = BUDGET * max(1.0, sum(len(recording) for recording in recordings) / BUDGET_SAMPLES)
    for turn in range(ROUNDS):
        if turn >= MIN_ROUNDS and time.process_time() - started > budget:
            complete = False
            break
        progress(2 * turn + 1, PROGRESS_STEPS, "comparing sets of effects")
        posterior, start = _posterior(fit, library, excluded, nameless=turn > 0)
        members = start
        if turn == 0:  # a search begins with what is calibrated in any case
            keys = {term.key for term in fit.calibrated.terms}
            members += tuple(number for number, term in enumerate(posterior.terms) if term.key in keys)
        members = search(posterior, members)
        progress(2 * turn + 2, PROGRESS_STEPS, "fitting effects and noise")
        terms, values = _refined(posterior, members)
        fit = fitted(signals, noise, terms, values, start=fit, disturbances=obstacles.disturbances)
        windows, _count = inflate_disturbed_windows(fit.regression, fit.regression.white[:, 0])
        noise = estimate_noise(windows, fit.regression.raw, noise, (noise.wave,))
        fit = fitted(signals, noise, fit.chosen.terms, fit.chosen.values, 1, fit, obstacles.disturbances)
        before, names = names, {(term.key, len(term.fixed.get("times", ()))) for term in terms}
        if turn > 0 and names == before:
            break
    # Residuals beyond noise have no candidate now: they count as noise, and disturbed windows are
    # down-weighted, so that they are not taken for a lasting effect.
    noise, disturbances = _noise_and_disturbances(fit)
    disturbances = [known + left for known, left in zip(obstacles.disturbances, disturbances, strict=True)]
    fit = fitted(signals, noise, fit.chosen.terms, fit.chosen.values, 1, fit, disturbances)
    progress(2 * ROUNDS + 1, PROGRESS_STEPS, "holding the answer against its rivals")
    posterior, start = _posterior(fit, library, excluded, scan=False)
    unknown = unknown_errors(posterior.regression)
    finish = partial(_final, signals, obstacles.disturbances, disturbances, unknown)
    best = finish(posterior, start, fit)
    if UNKNOWN not in excluded:
        wider = _with_unknown(best.posterior, start, unknown)
        other = finish(wider, start, fit)
        # an error of which no law can be written down is in no fit: the omnibus test holds it against chance
        outside = [wider.terms[member] for member in other.members if member not in other.named]
        lawless = any(not term.fixed["acts_on"] for term in outside)
        better = other.members != best.members and (lawless or predicts_better(other.fit, best.fit))
        best = other if better else replace(best, posterior=wider)
    return replace(best, complete=complete)


def _final(
    signals: tuple[Signals, ...],
    obstacle_disturbances: Sequence[Array],
    disturbances: Sequence[Array],
    unknown: UnknownErrors,
    posterior: Posterior,
    start: tuple[int, ...],
    fit: Fitted,
) -> Investigation:
    """Return the best set whose members all pass when they are fitted together with the calibration.

    Candidates that fail are removed, and the search resumes.
    """
    noise = fit.regression.noise
    known = dict(zip(start, zip(fit.chosen.terms, fit.chosen.values, strict=True), strict=True))
    members: tuple[int, ...] = start
    while True:
        members = search(posterior, members)
        named = tuple(member for member in members if posterior.terms[member].probes)
        terms, values = [], []
        for member in named:
            sizes = posterior.given(set(members) - {member}).judge(member).coefficients
            term, size = known.get(member, (posterior.terms[member], sizes))
            terms.append(term)
            values.append(size)
        conditional = posterior.given(named)
        for member in set(members) - set(named):
            for law in learned(posterior, conditional, posterior.terms[member]):
                terms.append(law)
                values.append(np.ones(len(law.probes)))
        fit = fitted(signals, noise, terms, values, 1, fit, disturbances)
        deviations = fit.squared_deviations()
        rejected = [
            member
            for number, member in enumerate(named)
            if not _is_accepted(fit.chosen.terms[number], fit.chosen.values[number], deviations[number])
        ]
        if not rejected:
            # disturbed windows do not identify effects, but they inform their sizes
            with_all_windows = fitted(signals, noise, terms, values, 1, fit, obstacle_disturbances)
            fit = with_all_windows if _agree(with_all_windows.chosen, fit.chosen) else fit
            return Investigation(signals, posterior, members, named, fit, unknown)
        posterior = posterior.without(rejected)
        members = tuple(member for member in members if member not in rejected)


def _is_accepted(term: Term, size: Array, squared_deviation: float) -> bool:
    """Say whether an effect of a fit may be present, given all others and the calibration.

    `squared_deviation` is that of its size (k,) from zero. No prior gives a size that is z standard
    deviations from zero a log Bayes factor beyond z^2/2 (Edwards, Lindman & Savage, Psychological Review
    1963). A bounded size may have come to zero, and beyond its largest size an effect is implausible.
    """
    is_plausible = NEGLIGIBLE_SIZE < float(np.abs(size).max()) <= term.largest
    return is_plausible and term.odds + 0.5 * squared_deviation > 0.0


def _agree(all_windows: Acting, undisturbed: Acting) -> bool:
    """Say whether sizes from all windows agree with those from undisturbed ones, to three sigma."""
    return all(
        bool(np.all(np.abs(size - reference) < MAX_DISAGREEMENT * np.sqrt(np.diagonal(covariance))))
        for size, reference, covariance in zip(
            all_windows.values, undisturbed.values, undisturbed.covariances(), strict=True
        )
    )


def _posterior(
    fit: Fitted, library: Sequence[Term], excluded: set[str], *, scan: bool = True, nameless: bool = True
) -> tuple[Posterior, tuple[int, ...]]:
    """Return the candidates about a fit's effects, and the numbers of those effects among them.

    Without a scan, pushes are still offered: a rejected event leaves them.
    """
    regression = fit.regression.branch()
    terms, places = list(fit.chosen.terms), list(fit.chosen.places)
    start = tuple(range(len(terms)))
    offered = merged(terms, library)
    places += regression.add(offered, keep=False)
    terms += offered
    posterior = posterior_with_background(regression, terms, places, fit.part)
    conditionals = [posterior.given(start), *([posterior.given(())] if start else [])]
    local = (
        events(regression, conditionals, nameless=nameless)
        if scan
        else push_terms(regression, [regression.push_scores(fit.residual) for fit in conditionals])
    )
    new = [term for term in merged(terms, local) if term.effect not in excluded]
    return posterior.with_more(new, regression.add(new, keep=False)), start


def posterior_with_background(
    regression: Regression, terms: Sequence[Term], places: Sequence[slice], shift: Array | float = 0.0
) -> Posterior:
    """Return candidates with the background of every robot, whose columns are added to the regression.

    The data are shifted back to those of the nominal robot. `shift` (V,) is the part of them that the base of
    the regression explains; nothing where that is the nominal robot.
    """
    numbers: list[int] = []
    sizes: list[float] = []
    names: dict[int, Key] = {}

    def include(place: slice, size: float, name: Key) -> None:
        columns = range(place.start, place.stop)
        numbers.extend(columns)
        sizes.extend([size] * len(columns))
        names.update(dict.fromkeys(columns, name))

    for candidate, place in zip(terms, places, strict=True):
        size = candidate.kind.background(candidate.component)
        if candidate.size == 1.0 and size:
            include(place, size, candidate.key)
    mounted = mounted_terms([windows.signals for windows in regression.windows])
    for place in (*regression.add(mounted, keep=False), add_nuisances(regression)):
        include(place, 1.0, ("nuisance", "any"))
    include(regression.append(regression.lagged_rows(LAGS)), LAG_SIZE, ("noise", "linkage"))
    regression.shift_data(shift)
    background = np.array(numbers, np.int64), np.array(sizes)
    return Posterior(Candidates(regression, list(terms), list(places), background, names))


def _with_unknown(posterior: Posterior, start: Sequence[int], unknown: UnknownErrors) -> Posterior:
    """Return the posterior with the likeliest unknown errors, given a set and given none."""
    offered, widths, columns = unknown.terms, unknown.widths, unknown.columns
    best: list[int] = []
    for conditional in (posterior.given(start), *([posterior.given(())] if start else [])):
        log_odds = np.array([term.odds for term in offered]) + conditional.log_bayes_factors(columns, widths)
        order = np.argsort(-log_odds, kind="stable").tolist()
        best += [number for number in order[:UNKNOWN_OFFERED] if number not in best]
    groups = slices_of(widths)
    added = posterior.regression.append(np.hstack([columns[:, groups[number]] for number in best]))
    places = slices_of((widths[number] for number in best), added.start)
    return posterior.with_more([offered[number] for number in best], places)


def _refined(posterior: Posterior, members: Sequence[int]) -> tuple[list[Term], list[np.ndarray]]:
    """Return a set's candidates with their moments refined, all bumps of a wheel in one, and coefficients."""
    regression = posterior.regression
    chosen, values = {}, {}
    for member in members:
        conditional = posterior.given(set(members) - {member})
        candidate = posterior.terms[member]
        if len(candidate.probes) == 1 and len(candidate.fixed.get("times", ())) < 2:
            candidate = refine(regression, conditional, candidate)
        chosen[member] = candidate
        values[member] = conditional.judge(member).coefficients
    terms, sizes = [], []
    for key in dict.fromkeys(candidate.key for candidate in chosen.values()):
        same = [member for member in chosen if chosen[member].key == key]
        if (
            chosen[same[0]].kind.scan == "moments"
            and len(same) > 1
            and all(chosen[member].held is None for member in same)
        ):
            pairs = sorted(
                (time, float(value))
                for member in same
                for time, value in zip(chosen[member].fixed["times"], values[member], strict=True)
            )
            terms.append(term(*key, regression.window_count, times=tuple(time for time, _ in pairs)))
            sizes.append(np.array([value for _, value in pairs]))
        else:
            terms += [chosen[member] for member in same]
            sizes += [values[member] for member in same]
    return terms, sizes


def startup_nuisances(library: Sequence[Term], signals: Sequence[Signals]) -> list[Term]:
    """Return the terms that any robot may have, which are nuisances until effects are obstacles."""
    with_poses = any(recording.poses is not None for recording in signals)
    when = {"always", "with poses"} if with_poses else {"always"}
    return [term for term in library if term.kind.startup_nuisance in when and term.size == 1.0]


def whiten_with_estimated_noise(regression: Regression, *, roughly: bool = False) -> Regression:
    """Estimate noise levels of an uncalibrated robot by maximum likelihood; return the regression with them.

    Two passes: all windows, then all with disturbed ones down-weighted (a one-step M-estimator). Roughly, one
    pass, one length of the floor's waves and a coarse tolerance will do.
    """
    waves, tolerance = ((regression.noise.wave,), ROUGH) if roughly else (WAVES, FINE)
    if not roughly:
        raw, noise = regression.raw, regression.noise
        regression = regression.with_noise(estimate_noise(regression.windows, raw, noise, (noise.wave,)))
    windows, _count = inflate_disturbed_windows(regression, regression.residual())
    return regression.with_noise(estimate_noise(windows, regression.raw, regression.noise, waves, tolerance))


def _noise_and_disturbances(fit: Fitted) -> tuple[NoiseLevels, list[Array]]:
    """Return noise levels from all windows, and of each recording the disturbances `(M, n, n)`.

    The disturbances are process covariances in disturbed windows without a candidate; next to an event they
    are its discrepancy, which is no noise either.
    """
    regression = fit.regression
    windows, _count = inflate_disturbed_windows(regression, regression.white[:, 0])
    intervals = [interval for term in fit.chosen.terms for interval in term.active_intervals]
    counted, disturbances = [], []
    for inflated, original in zip(windows, regression.windows, strict=True):
        near = is_near(original.time[:-1], intervals)[:, None, None]
        inflation = inflated.rounding - original.rounding
        disturbances.append(np.where(near, 0.0, inflation))
        counted.append(replace(original, rounding=original.rounding + np.where(near, inflation, 0.0)))
    noise = estimate_noise(counted, regression.raw, regression.noise, (regression.noise.wave,))
    return noise, disturbances
