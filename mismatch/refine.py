"""From the linear search to the effects themselves: their parameters by Gauss-Newton."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from omnimate.mismatch.choose import Choice, decoded, tails, thinned, tolerant
from omnimate.mismatch.folds import folds_of
from omnimate.mismatch.model import relinearised
from omnimate.mismatch.moments import events_of, firm, looseness, settle
from omnimate.mismatch.regression import Regression
from omnimate.mismatch.terms import skews
from omnimate.mismatch.windows import windows_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from omnimate.mismatch.choose import Set
    from omnimate.mismatch.diagnosis import Key
    from omnimate.mismatch.investigate import Investigation
    from omnimate.mismatch.moments import Loose
    from omnimate.mismatch.terms import Term
    from omnimate.vcan_sim.effects.effect import Effect
    from omnimate.vehicle.se2 import Array

AROUND = 0.6  # [s] before and after an event in which every sample is measured
_RIVALS = 4  # that are fitted beside the best set
_CLOSE = 12.0  # log odds by which a set may lie behind
_PART = 0.15  # of the best set's own, likewise
TURNS = 2  # of Gauss-Newton: the effects are small, and the second turn changes them by their square


@dataclass(frozen=True, slots=True)
class Refined:
    """Effects as they fit best.

    Attributes:
        terms: of the best set, with what is not linear refined.
        effects: one for each term.
        values: of each term's coefficients `(k,)`.
        covariances: of them `(k, k)`.
        loose: of each term the standard deviations of what is not linear, by name.
        regression: about the effects, with the terms' columns.
        places: of the columns.
    """

    terms: tuple[Term, ...]
    effects: tuple[Effect, ...]
    values: tuple[Array, ...]
    covariances: tuple[Array, ...]
    loose: tuple[Loose, ...]
    regression: Regression
    places: tuple[slice, ...]


def refine(found: Investigation, turns: int = TURNS) -> Refined:
    """Return the best set's effects with all of their parameters fitted, in turns of Gauss-Newton."""
    members = [one for one in found.members() if one.effect != "unknown"]
    noise, linear = found.regression.noise, found.regression.windows
    terms, loose = _placed(found, members)
    folds = folds_of(linear)
    regression = Regression(linear, noise, (), folds)
    skewed = regression.add(skews(linear[0].signals))
    places = regression.add(terms)
    sizes = np.zeros(regression.white.shape[1])
    sizes[1 : 1 + len(skewed)] = 1.0
    choice = Choice(terms, places, tolerant(regression.total, sizes))
    kept = sorted(thinned(choice, frozenset(range(len(terms)))))
    values = [coefficients for _, coefficients, _ in decoded(choice, kept)]
    bent = fitted(found, [terms[one] for one in kept], values, turns)
    return replace(bent, loose=tuple(loose[one] for one in kept))


def keeping(found: Investigation, refined: Refined, keys: Iterable[Key], turns: int) -> Refined:
    """Return only the effects of some names and components, fitted without the others."""
    known = set(keys)
    kept = [number for number, one in enumerate(refined.terms) if one.key in known]
    if len(kept) == len(refined.terms):
        return refined
    terms, values = [refined.terms[one] for one in kept], [refined.values[one] for one in kept]
    return replace(fitted(found, terms, values, turns), loose=tuple(refined.loose[one] for one in kept))


def fitted(
    found: Investigation, terms: Sequence[Term], values: Sequence[Array], turns: int = TURNS
) -> Refined:
    """Return terms with their coefficients fitted by Gauss-Newton, each turn about what the last one found.

    Args:
        found: whose recordings and noise to take.
        terms: to fit.
        values: of their coefficients, from which to start.
        turns: of Gauss-Newton; with none the effects stay as they are.
    """
    noise, linear, folds = found.regression.noise, found.regression.windows, found.regression.folds
    terms, everything, windows = [one.fine() for one in terms], range(len(terms)), linear
    for _ in range(turns):
        effects = [one.built(own) for one, own in zip(terms, values, strict=True)]
        windows = [windows_of(relinearised(one.signals, effects), kicks=one.kicks) for one in linear]
        regression = Regression(windows, noise, effects, folds)
        places = regression.add(terms)
        moved = decoded(Choice(terms, places, regression.total), everything)
        values = [own + step for own, (_, step, _) in zip(values, moved, strict=True)]
    effects = [one.built(own) for one, own in zip(terms, values, strict=True)]
    regression = Regression(windows, noise, effects, folds)
    places = regression.add(terms)
    last = decoded(Choice(terms, places, regression.total), everything)
    covariances = tuple(covariance for _, _, covariance in last)
    return Refined(
        tuple(terms),
        tuple(effects),
        tuple(values),
        covariances,
        tuple({} for _ in terms),
        regression,
        tuple(places),
    )


def contend(found: Investigation) -> None:
    """Let rivals of the best set compete as they really are, not as straight lines.

    Large effects differ from each other by their squares: a turned axle of a degree is then no longer a
    joint's bias. Every set that comes near the best one is fitted by Gauss-Newton, and its worth corrected
    by what that takes from the chi-square.
    """
    choice, best = found.choice, found.chosen
    if not best or _loose(choice, best):
        return
    strange = any(choice.terms[one].effect == "unknown" for one in best)
    gain = choice.worth(best)
    near = [
        rival
        for rival, worth in sorted(choice.known.items(), key=lambda item: -item[1])
        if rival != best
        and len(rival) == len(best)
        and len(rival & best) == len(best) - 1
        and worth > gain - max(_CLOSE, _PART * gain)
        and not any(choice.terms[one].effect == "unknown" for one in rival)
        and not _loose(choice, rival)
    ][:_RIVALS]
    if not near:
        return
    corrections = {one: _correction(found, one) for one in near}
    # what is unknown has no law that could bend; nor has any set that was not tried
    rest = 0.0 if strange else _correction(found, best)
    for one in choice.known:
        if one:
            choice.known[one] += corrections.get(one, rest)
    found.chosen = max((best, *near), key=choice.worth)


def _loose(choice: Choice, members: Set) -> bool:
    """Say whether a set holds a loosened shape: that has bent already."""
    return any(0 < len(choice.terms[one].probes) < len(choice.columns([one])) for one in members)


def _correction(found: Investigation, members: Set) -> float:
    """Return what a set is worth more when it is fitted by Gauss-Newton: Laplace's approximation there."""
    choice, total = found.choice, found.regression.total
    lines = found.untolerant()  # on either side of the difference
    before = lines.worth(members)
    if not np.isfinite(before):
        return 0.0  # a size below zero, which only what is tolerated makes sense of
    straight = decoded(lines, members)
    bent = fitted(found, [choice.terms[one] for one, _, _ in straight], [own for _, own, _ in straight])
    columns = bent.regression.white[:, bent.places[0].start : bent.places[-1].stop]
    values, left = np.concatenate(bent.values), bent.regression.white[:, 0]
    scarce, prior = tails(values, [(len(own), 0) for own in bent.values])
    volume = float(np.linalg.slogdet(columns.T @ columns + np.diag(scarce))[1])
    evidence = 0.5 * float(total[0, 0] - left @ left - values @ (scarce * values)) - 0.5 * volume + prior
    return evidence + sum(choice.prior(one) for one in members) - before


def _placed(found: Investigation, members: Sequence[Term]) -> tuple[list[Term], list[Loose]]:
    """Return members with their events where they fit best, to the sample, and how sure that is."""
    moments = [at for member in members for at in events_of(member)]
    dense = [(at - AROUND, at + AROUND) for at in moments]
    windows = found.regression.windows
    if dense:
        windows = [windows_of(one.signals, dense, one.kicks) for one in windows]
    regression = Regression(windows, found.regression.noise, (), folds_of(windows))
    settled = firm(regression, settle(regression, members))
    return settled, looseness(regression, settled)
