"""Search for the most probable set of candidates: members are added, pruned, exchanged and merged."""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING

import numpy as np

from omnimate.effects import EFFECTS
from omnimate.mismatch.evidence.conditional_fit import IMPOSSIBLE
from omnimate.mismatch.evidence.density import MEMBER_SIZE

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from omnimate.mismatch.candidates.terms import Term
    from omnimate.mismatch.evidence.conditional_fit import ConditionalFit, Judgement
    from omnimate.mismatch.evidence.posterior import Posterior

FULLY_JUDGED = 12  # candidates of the highest approximate odds that are judged in full
PAIRED_CANDIDATES = 40  # candidates, likewise, whose pairs are compared
MAX_MEMBERS = 10  # of a set: more events than that are the floor's roughness
JUDGED_REPLACEMENTS = 3  # of two members, the likeliest, that are judged in full
EVENT_SEPARATION = 1.0  # [s] below which two events of a component are one
MAX_PASSES = 3  # of the search
NAMELESS_MARGIN = 5.0  # [log odds] 150 to 1: by so much the data must prefer an unknown error to an effect
CERTAIN_LOG_ODDS = 25.0  # beyond which a member is not judged again

Members = tuple[int, ...]


def search(posterior: Posterior, start: Iterable[int] = ()) -> Members:
    """Return the set of candidates to which adding, pruning and exchanging lead from a start."""
    members = _prune(posterior, tuple(sorted(start)))
    seen = set()
    for _ in range(MAX_PASSES):
        members = _exchange(posterior, _prune(posterior, _grow(posterior, members)))
        members = _merge_two_members(posterior, members)
        if members in seen:
            break
        seen.add(members)
    return _prune(posterior, members)


def ranked_candidates(posterior: Posterior, conditional: ConditionalFit) -> list[int]:
    """Return the candidates that may join a set, by their approximate odds, the best first."""
    terms = posterior.terms
    used_keys = {terms[candidate].key for candidate in conditional.members if not terms[candidate].is_event}
    named = {  # a wrong number is constant, and what is unknown varies: a component may have both
        terms[candidate].component
        for candidate in conditional.members
        if not (terms[candidate].is_unknown or terms[candidate].kind.calibrated)
    }
    occupied = [
        (terms[candidate].component, time)
        for candidate in conditional.members
        for time in (*terms[candidate].fixed.get("times", ()), *_onset(terms[candidate]))
    ]
    allowed = [
        candidate
        for candidate, term in enumerate(terms)
        if candidate not in conditional.members
        and term.key not in used_keys
        and not (term.is_unknown and not term.is_event and term.component in named)
        and not _repeats_event(term.component, term.fixed.get("times", ()), occupied)
        and conditional.approximate_log_odds[candidate] > IMPOSSIBLE
    ]
    return sorted(allowed, key=lambda candidate: -conditional.approximate_log_odds[candidate])


def is_push(term: Term) -> bool:
    """Say whether a candidate is a push of a truck: an unknown error of any shape, at some moment."""
    return term.is_unknown and term.is_event


def overlap(stretches: Sequence[tuple[float, float]], others: Sequence[tuple[float, float]]) -> bool:
    """Say whether some stretches (begin, end) [s] are during others, or shortly before or after."""
    return any(
        start - EVENT_SEPARATION < end and begin < stop + EVENT_SEPARATION
        for start, stop in stretches
        for begin, end in others
    )


def _onset(term: Term) -> tuple[float, ...]:
    """Return when a lasting change begins [s]: an event at that moment is the change itself."""
    return (term.fixed["time"],) if "time" in term.fixed else ()


def _repeats_event(component: str, times: Sequence[float], occupied: Sequence[tuple[str, float]]) -> bool:
    """Say whether an event of a component, or of its truck or one of its wheels, is already in a set."""
    if not times or not occupied:
        return False
    times_of_component = [
        occupied_time
        for other, occupied_time in occupied
        if component.startswith(other) or other.startswith(component)
    ]
    return any(
        abs(time - occupied_time) < EVENT_SEPARATION for time in times for occupied_time in times_of_component
    )


def _best(posterior: Posterior, conditional: ConditionalFit) -> tuple[int, Judgement] | None:
    """Return the best candidate to join a set, judged in full."""
    shortlist = ranked_candidates(posterior, conditional)[:FULLY_JUDGED]
    judged = list(zip(shortlist, conditional.judge_all(shortlist), strict=True))
    winner = _best_of(judged)
    named = [pair for pair in judged if not posterior.terms[pair[0]].is_unknown and pair[1].log_odds > 0.0]
    best_named = _best_of(named)
    if winner is None or best_named is None:
        return winner
    return winner if may_replace(posterior, *winner, *best_named) else best_named


def _best_of(judged: Sequence[tuple[int, Judgement]]) -> tuple[int, Judgement] | None:
    """Return the candidate of the highest odds under white noise, preferring those of positive log odds."""
    return max(judged, key=lambda pair: (pair[1].log_odds > 0.0, pair[1].white_log_odds), default=None)


def may_replace(
    posterior: Posterior, rival: int, rival_judgement: Judgement, member: int, judgement: Judgement
) -> bool:
    """Say whether a rival may replace a member.

    Unknown errors fit anything: to replace an effect, the data must support them more by a margin, or, where
    they are the likelier ones, predict unseen data more by it.
    """
    terms = posterior.terms
    if terms[member].is_unknown or not terms[rival].is_unknown:
        return True
    if rival_judgement.white_log_evidence > judgement.white_log_evidence + NAMELESS_MARGIN:
        return True
    likelier = rival_judgement.white_log_odds > judgement.white_log_odds
    return likelier and rival_judgement.log_odds > judgement.log_odds + NAMELESS_MARGIN


def _grow(posterior: Posterior, members: Members) -> Members:
    """Return a set with candidates added as long as that raises the odds."""
    while len(members) < MAX_MEMBERS:
        conditional = posterior.given(members)
        winner, evidence = _best(posterior, conditional), posterior.evidence(members)
        if winner and winner[1].log_odds > 0.0 and posterior.evidence({*members, winner[0]}) > evidence:
            events = _with_certain_events(posterior, conditional, winner[0])[: MAX_MEMBERS - len(members)]
            members = tuple(sorted({*members, *events}))
            continue
        pair = _best_pair(posterior, conditional, evidence)
        if pair is None:
            return members
        members = tuple(sorted({*members, *pair}))
    return members


def _with_certain_events(posterior: Posterior, conditional: ConditionalFit, first: int) -> list[int]:
    """Return a candidate and, if it is an event, all other probable events far from it."""
    terms, chosen = posterior.terms, [first]
    if not terms[first].is_event:
        return chosen
    for candidate in ranked_candidates(posterior, conditional):
        if (
            not terms[candidate].is_event
            or candidate == first
            or conditional.approximate_log_odds[candidate] < 3.0
        ):
            continue
        times = [time for other in chosen for time in terms[other].fixed["times"]]
        if all(
            abs(time - event_time) > EVENT_SEPARATION
            for time in times
            for event_time in terms[candidate].fixed["times"]
        ):
            chosen.append(candidate)
    return chosen


def _best_pair(posterior: Posterior, conditional: ConditionalFit, threshold: float) -> tuple[int, int] | None:
    """Return two candidates that raise the odds together, though neither does alone: they mask each other.

    The set with them must exceed a threshold of log posterior odds.
    """
    terms = posterior.terms
    shortlist = [
        candidate
        for candidate in ranked_candidates(posterior, conditional)
        if len(terms[candidate].probes) == 1
    ][:PAIRED_CANDIDATES]
    if not shortlist:
        return None
    columns = [posterior.places[candidate].start for candidate in shortlist]
    prior_odds = np.array([terms[candidate].odds for candidate in shortlist])
    gram, score = conditional.gram_and_score(columns)
    precision = gram + np.eye(len(shortlist)) / MEMBER_SIZE**2
    precisions = np.diagonal(precision)
    area = np.maximum(precisions[:, None] * precisions[None, :] - precision**2, 1e-12)
    first_size = (precisions[None, :] * score[:, None] - precision * score[None, :]) / area
    log_odds = 0.5 * (first_size * score[:, None] + first_size.T * score[None, :]) - 0.5 * np.log(area)
    log_odds += prior_odds[:, None] + prior_odds[None, :] - 2.0 * math.log(MEMBER_SIZE)
    positive = np.array([terms[candidate].positive for candidate in shortlist])
    wrong = positive[:, None] & (first_size < 0.0)
    log_odds[wrong | wrong.T] = IMPOSSIBLE
    rows, others = np.triu_indices(len(shortlist), 1)
    pairs = [
        (float(log_odds[row, other]), shortlist[row], shortlist[other])
        for row, other in zip(rows.tolist(), others.tolist(), strict=True)
        if log_odds[row, other] > 0.0 and terms[shortlist[row]].key != terms[shortlist[other]].key
    ]
    for _, first, second in sorted(pairs, reverse=True)[:3]:
        pair = tuple(sorted((*conditional.members, first, second)))
        if posterior.evidence(pair) > threshold and all(
            posterior.given(tuple(other for other in pair if other != candidate)).judge(candidate).log_odds
            > 0.0
            for candidate in (first, second)
        ):
            return first, second
    return None


def _prune(posterior: Posterior, members: Members) -> Members:
    """Return a set without the members whose odds, given the others, are below even.

    Of members that are impossible together, the likelier stay.
    """
    members = _without_what_cancels(posterior, members)
    certain: set[int] = set()
    while members:
        judged = [member for member in members if member not in certain]
        log_odds = {
            member: posterior.given(set(members) - {member}).judge(member).log_odds for member in judged
        }
        worst = min(log_odds, key=lambda member: log_odds[member], default=None)
        if worst is None or log_odds[worst] > 0.0:
            return members
        if log_odds[worst] == IMPOSSIBLE:
            evidence_without = {member: posterior.evidence(set(members) - {member}) for member in members}
            worst = max(evidence_without, key=lambda member: evidence_without[member])
        members = tuple(member for member in members if member != worst)
        # a certain member is judged once: removing others only raises its odds
        certain |= {member for member, member_odds in log_odds.items() if member_odds > CERTAIN_LOG_ODDS}
    return members


def _without_what_cancels(posterior: Posterior, members: Members) -> Members:
    """Return a set without effects of one kind on several components, if it is likelier without all of them.

    Of a relative effect, such as a delay, a common amount on all components cannot be observed: each member
    is needed given the others, and none alone. If all components but one have it, that one has the opposite
    instead, unless that is impossible.
    """
    terms = posterior.terms
    for kind in (kind.name for kind in EFFECTS if kind.relative):
        affected = {terms[member].component for member in members if terms[member].effect == kind}
        unaffected = [
            candidate
            for candidate, term in enumerate(terms)
            if term.effect == kind and term.component not in affected
        ]
        if len(affected) > 1 and len({terms[candidate].component for candidate in unaffected}) <= 1:
            others = (member for member in members if terms[member].effect != kind)
            opposite = [candidate for candidate in unaffected if not terms[candidate].positive][:1]
            members = tuple(sorted((*others, *opposite)))
    for effect in sorted({posterior.terms[member].effect for member in members}):
        rest = tuple(member for member in members if posterior.terms[member].effect != effect)
        if len(members) - len(rest) > 1 and posterior.evidence(rest) > posterior.evidence(members):
            members = rest
    return members


def _exchange(posterior: Posterior, members: Members) -> Members:
    """Return a set with members exchanged for candidates of higher odds."""
    for old in members:
        if old not in members:
            continue
        rest = tuple(member for member in members if member != old)
        conditional = posterior.given(rest)
        if posterior.terms[old].is_event:
            replacement = _best_event_at(posterior, conditional, old)
        else:
            pair = _best_pair(posterior, conditional, posterior.evidence(members))
            if pair is not None:
                members = tuple(sorted({*rest, *pair}))
                continue
            replacement = _best(posterior, conditional)
        if replacement is None or replacement[0] == old:
            continue
        judgement = conditional.judge(old)
        if not may_replace(posterior, replacement[0], replacement[1], old, judgement):
            continue
        if replacement[1].log_odds > 0.0 and replacement[1].white_log_odds > judgement.white_log_odds:
            members = tuple(sorted({*rest, replacement[0]}))
    return members


def _merge_two_members(posterior: Posterior, members: Members) -> Members:
    """Return a set with two members replaced by one candidate, if the set is then likelier."""
    for first, second in itertools.combinations(members, 2):
        for candidate, gain in replacements_of_two(posterior, members, first, second):
            conditional = posterior.given(set(members) - {first, second})
            if gain > 0.0 and conditional.judge(candidate).log_odds > 0.0:
                return tuple(sorted({*conditional.members, candidate}))
    return members


def replacements_of_two(
    posterior: Posterior, members: Members, first: int, second: int
) -> list[tuple[int, float]]:
    """Return candidates that may replace two members, and the gain of the set's log odds, the largest first.

    Two effects may each explain a part of a third one, of an unknown error on the same component, or, while
    they act, of a push. An effect must have positive log odds there; an unknown error counts in any case.
    """
    terms, rest = posterior.terms, set(members) - {first, second}
    events = terms[first].is_event and terms[second].is_event  # what lasts is offered in the place of each
    used_keys = {terms[candidate].key for candidate in rest}
    parts = terms[first].component, terms[second].component
    candidates = [
        candidate
        for candidate, term in enumerate(terms)
        if (_pushes_both(term, terms[first], terms[second]) if term.is_local else not events)
        and term.key not in used_keys
        and candidate not in members
        and (term.probes or all(part.startswith(term.component) for part in parts))
    ]
    if not candidates:
        return []
    conditional, evidence = posterior.given(rest), posterior.evidence(members)
    gains = [
        (candidate, posterior.evidence({*rest, candidate}) - evidence)
        for candidate in candidates
        if conditional.approximate_log_odds[candidate] > 0.0
    ]
    likeliest = sorted(gains, key=lambda pair: -pair[1])[:JUDGED_REPLACEMENTS]
    return [
        pair for pair in likeliest if not terms[pair[0]].probes or conditional.judge(pair[0]).log_odds > 0.0
    ]


def _pushes_both(term: Term, first: Term, second: Term) -> bool:
    """Say whether a candidate is a push during two events: each may explain a part of it."""
    return (
        is_push(term)
        and not (is_push(first) or is_push(second))
        and overlap(term.stretches, first.stretches)
        and overlap(term.stretches, second.stretches)
    )


def _best_event_at(
    posterior: Posterior, conditional: ConditionalFit, old: int
) -> tuple[int, Judgement] | None:
    """Return the best event at the same moments as another."""
    terms = posterior.terms
    times = terms[old].fixed["times"]
    simultaneous = [
        candidate
        for candidate, term in enumerate(terms)
        if term.is_event
        and candidate not in conditional.members
        and len(term.fixed["times"]) == len(times)
        and all(
            abs(time - event_time) < EVENT_SEPARATION
            for time, event_time in zip(times, term.fixed["times"], strict=True)
        )
    ]
    return _best_of(list(zip(simultaneous, conditional.judge_all(simultaneous), strict=True)))
