"""What a finding is held against: the probabilities of its rivals, over resampled recordings."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.mismatch.evidence.conditional_fit import IMPOSSIBLE
from omnimate.mismatch.evidence.search import (
    FULLY_JUDGED,
    may_replace,
    overlap,
    ranked_candidates,
    replacements_of_two,
)

if TYPE_CHECKING:
    from omnimate.mismatch.diagnosis import Key
    from omnimate.mismatch.evidence.conditional_fit import ConditionalFit, Judgement
    from omnimate.mismatch.evidence.posterior import Posterior
    from omnimate.mismatch.investigate import Investigation
    from omnimate.vehicle.se2 import Array

DRAWS = 200  # resampled recordings: a probability of 0.9 is then known to 0.02
POSSIBLE = 0.01  # probability below which an alternative is not worth a word


@dataclass(frozen=True, slots=True)
class Rivalry:
    """What a member of the best set is held against."""

    probability: float  # that it is there
    rivals: tuple[tuple[Key, float], ...]  # what may stand in its place, likeliest first


def rivalry(investigation: Investigation, member: int) -> Rivalry:
    """Return the probabilities of a member and of its rivals, beside the other members.

    They are means over recordings resampled from the stretches of this one (Huggins and Miller, Bayesian
    Analysis 2023): of two models, neither exact, the posterior of a single recording is sure of either by
    chance.
    What happened once, at some moment, cannot be drawn again.
    """
    posterior = investigation.posterior
    rest = set(investigation.members) - {member}
    conditional, member_key = posterior.given(rest), posterior.terms[member].key
    judged = _judged(posterior, conditional, member)
    itself = judged[member_key][member]
    draws = _draws(posterior, member)
    likeliest = max(
        (judgement for variants in judged.values() for judgement in variants.values()),
        key=lambda judgement: (judgement.log_odds > 0.0, judgement.white_log_odds),
    )
    worths = {
        key: np.logaddexp.reduce(
            [
                _against(judgement, likeliest)
                + conditional.bootstrap_gain(candidate, draws) / likeliest.overdispersion
                for candidate, judgement in variants.items()
            ]
        )
        for key, variants in judged.items()
    }
    # a third effect may stand in the place of this member and of another
    gain_of_all = posterior.bootstrap_gain(investigation.members, draws)
    for other in rest:
        for candidate, gain in replacements_of_two(posterior, investigation.members, member, other):
            key = posterior.terms[candidate].key
            if key == member_key:
                continue
            change = posterior.bootstrap_gain({*rest, candidate} - {other}, draws) - gain_of_all
            instead = worths[member_key] + (gain + change) / itself.overdispersion
            worths[key] = np.maximum(worths.get(key, IMPOSSIBLE), instead)
    every = np.stack([np.zeros(len(draws)), *worths.values()])
    shares = np.exp(every - np.logaddexp.reduce(every)).mean(axis=1)[1:]
    others = sorted(
        ((key, float(share)) for key, share in zip(worths, shares, strict=True) if key != member_key),
        key=lambda pair: -pair[1],
    )
    return Rivalry(float(shares[list(worths).index(member_key)]), tuple(others))


def _judged(
    posterior: Posterior, conditional: ConditionalFit, member: int
) -> dict[Key, dict[int, Judgement]]:
    """Return by name the judgements of a member and of what may stand in its place.

    Variants of a name share its prior odds, and count together: a size, a moment or a limit was looked for.
    """
    itself, name = conditional.judge(member), posterior.terms[member].key
    judged, best = {name: {member: itself}}, {name: conditional.approximate_log_odds[member]}
    for candidate in ranked_candidates(posterior, conditional):
        if _elsewhere(posterior, candidate, member):
            continue
        key, quick = posterior.terms[candidate].key, conditional.approximate_log_odds[candidate]
        if quick < best.setdefault(key, quick) + math.log(POSSIBLE):
            continue
        if len(best) > FULLY_JUDGED:
            break
        judgement = conditional.judge(candidate)
        if may_replace(posterior, candidate, judgement, member, itself):
            judged.setdefault(key, {})[candidate] = judgement
    return judged


def _draws(posterior: Posterior, member: int) -> Array:
    """Return how often each stretch is in each of some resampled recordings, `(n, stretches)`."""
    count = int(posterior.candidates.stretch.max()) + 1
    if posterior.terms[member].is_local:
        return np.ones((1, count))
    chance = np.random.default_rng(0)
    return chance.multinomial(count, np.full(count, 1.0 / count), size=DRAWS).astype(float)


def _against(judgement: Judgement, likeliest: Judgement) -> float:
    """Return the log posterior odds of a candidate, given the likeliest: rivals share the noise."""
    if judgement.log_odds <= 0.0:
        return judgement.log_odds
    odds = (judgement.white_log_odds - judgement.white_log_evidence) - (
        likeliest.white_log_odds - likeliest.white_log_evidence
    )
    return (
        likeliest.log_odds
        + odds
        + (judgement.white_log_evidence - likeliest.white_log_evidence) / likeliest.overdispersion
    )


def _elsewhere(posterior: Posterior, candidate: int, member: int) -> bool:
    """Say whether both are events at other moments: one does not stand in the place of the other."""
    event, other = posterior.terms[member], posterior.terms[candidate]
    return event.is_event and other.is_event and not overlap(event.stretches, other.stretches)
