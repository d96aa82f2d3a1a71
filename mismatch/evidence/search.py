"""The search for the set of candidates that explains a recording: grown, thinned, exchanged."""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING

import numpy as np

from omnimate.effects import EFFECTS
from omnimate.mismatch.evidence.beside import NOTHING
from omnimate.mismatch.evidence.density import LARGEST

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from omnimate.mismatch.candidates.terms import Term
    from omnimate.mismatch.evidence.beside import Beside, Judgement
    from omnimate.mismatch.evidence.posterior import Posterior

LOOKED_AT = 12  # candidates of the highest evidence that are judged in full
PAIRED = 40  # candidates, likewise, whose pairs are looked at
MOST = 10  # members of a set: a floor with more events than that is a floor, not a list
OFFERS = 3  # in the place of two members, the likeliest, that are judged in full
APART = 1.0  # [s] between two events that are added at once
PASSES = 3
BETTER = 5.0  # log odds of 150 by which the data must support what has no name more than a name
SURE = 25.0  # log odds

Members = tuple[int, ...]


def search(posterior: Posterior, start: Iterable[int] = ()) -> Members:
    """Return the set of candidates that growing, thinning and exchanging lead to.

    Args:
        posterior: Of the candidates.
        start: Set from which to look.
    """
    members = _thinned(posterior, tuple(sorted(start)))
    seen = set()
    for _ in range(PASSES):
        members = _exchanged(posterior, _thinned(posterior, _grown(posterior, members)))
        members = _joined(posterior, members)
        if members in seen:
            break
        seen.add(members)
    return _thinned(posterior, members)


def ranked(posterior: Posterior, beside: Beside, without: Iterable[int] = ()) -> list[int]:
    """Return the candidates that may stand beside a set, by their evidence, the best first."""
    terms, left_out = posterior.terms, set(without)
    taken = {terms[single].key for single in beside.members if not terms[single].is_event}
    named = {terms[single].component for single in beside.members if not terms[single].is_unknown}
    moments = [
        (terms[single].component, time)
        for single in beside.members
        for time in (*terms[single].fixed.get("times", ()), *_begin(terms[single]))
    ]
    others = [terms[single] for single in beside.members]
    quick = {
        single: beside.quick(single)
        for single, term in enumerate(terms)
        if single not in beside.members
        and single not in left_out
        and term.key not in taken
        and not (term.is_unknown and not term.is_event and term.component in named)
        and not _again(term.component, term.fixed.get("times", ()), moments)
        and not (is_push(term) and _is_left(posterior, term, others))
    }
    return sorted((single for single in quick if quick[single] > NOTHING), key=lambda single: -quick[single])


def is_push(term: Term) -> bool:
    """Say whether a candidate is a push of a truck, which has no name and any shape."""
    return term.is_unknown and term.is_event


def overlap(stretches: Sequence[tuple[float, float]], others: Sequence[tuple[float, float]]) -> bool:
    """Say whether some stretches (begin, end) [s] are during others, or shortly before or after."""
    return any(
        start - APART < end and begin < stop + APART for start, stop in stretches for begin, end in others
    )


def _is_left(posterior: Posterior, push: Term, events: Iterable[Term]) -> bool:
    """Say whether a push is what the laws of some events leave: no law is exact.

    It is then of the same truck; without poses, a push of one truck shows as one of the other.
    """
    posed = any(windows.signals.poses is not None for windows in posterior.regression.windows)
    return any(
        overlap(push.stretches, event.happening)
        for event in events
        if not posed or event.component.startswith(push.component)
    )


def _begin(term: Term) -> tuple[float, ...]:
    """Return when a lasting change begins [s]: what happens then is how it comes about."""
    return (term.fixed["time"],) if "time" in term.fixed else ()


def _again(component: str, times: Sequence[float], moments: Sequence[tuple[str, float]]) -> bool:
    """Say whether an event of a component, or of its truck or one of its wheels, is already in a set."""
    if not times or not moments:
        return False
    same = [moment for other, moment in moments if component.startswith(other) or other.startswith(component)]
    return any(abs(time - moment) < APART for time in times for moment in same)


def best(posterior: Posterior, beside: Beside, count: int = LOOKED_AT) -> tuple[int, Judgement] | None:
    """Return the candidate that is worth most beside a set, judged in full."""
    offers = ranked(posterior, beside)[:count]
    judged = list(zip(offers, beside.judge_all(offers), strict=True))
    first = _first(judged)
    named = [pair for pair in judged if not posterior.terms[pair[0]].is_unknown and pair[1].worth > 0.0]
    other = _first(named)
    if first is None or other is None:
        return first
    return first if believable(posterior, *first, *other) else other


def _first(judged: Sequence[tuple[int, Judgement]]) -> tuple[int, Judgement] | None:
    """Return the candidate that is worth most against its rivals, of those that are worth anything."""
    return max(judged, key=lambda pair: (pair[1].worth > 0.0, pair[1].rank), default=None)


def believable(posterior: Posterior, rival: int, its: Judgement, member: int, own: Judgement) -> bool:
    """Say whether a rival may stand in a member's place at all.

    What has no name fits anything: in the place of a name the data must support it better, by the same noise.
    """
    terms = posterior.terms
    nameless = terms[rival].is_unknown and not terms[member].is_unknown
    return not nameless or its.support > own.support + BETTER


def _grown(posterior: Posterior, members: Members) -> Members:
    """Return a set with candidates added as long as one is worth adding."""
    while len(members) < MOST:
        beside = posterior.beside(members)
        offer = best(posterior, beside)
        if offer is not None and offer[1].worth > 0.0 and _better(posterior, members, (offer[0],)):
            together = _together(posterior, beside, offer[0])[: MOST - len(members)]
            members = tuple(sorted({*members, *together}))
            continue
        pair = _pair(posterior, beside, posterior.evidence(members))
        if pair is None:
            return members
        members = tuple(sorted({*members, *pair}))
    return members


def _better(posterior: Posterior, members: Members, more: Sequence[int]) -> bool:
    return posterior.evidence({*members, *more}) > posterior.evidence(members)


def _together(posterior: Posterior, beside: Beside, first: int) -> list[int]:
    """Return a candidate, and, if it is an event, all others far from it that are sure as well."""
    terms, chosen = posterior.terms, [first]
    if not terms[first].is_event:
        return chosen
    for single in ranked(posterior, beside):
        if not terms[single].is_event or single == first or beside.quick(single) < 3.0:
            continue
        times = [time for other in chosen for time in terms[other].fixed["times"]]
        if all(abs(time - own) > APART for time in times for own in terms[single].fixed["times"]):
            chosen.append(single)
    return chosen


def _pair(posterior: Posterior, beside: Beside, least: float) -> tuple[int, int] | None:
    """Return two candidates that are worth adding together, though neither is alone: they hide each other.

    Args:
        posterior: Of the candidates.
        beside: The set to which they are added.
        least: Log posterior odds that the set with them must exceed.
    """
    terms = posterior.terms
    alone = [single for single in ranked(posterior, beside) if len(terms[single].probes) == 1][:PAIRED]
    if not alone:
        return None
    columns = [posterior.places[single].start for single in alone]
    odds = np.array([terms[single].odds for single in alone])
    gram, score = beside.left(columns)
    precision = gram + np.eye(len(alone)) / LARGEST**2
    own = np.diagonal(precision)
    area = np.maximum(own[:, None] * own[None, :] - precision**2, 1e-12)
    first_size = (own[None, :] * score[:, None] - precision * score[None, :]) / area
    worth = 0.5 * (first_size * score[:, None] + first_size.T * score[None, :]) - 0.5 * np.log(area)
    worth += odds[:, None] + odds[None, :] - 2.0 * math.log(LARGEST)
    positive = np.array([terms[single].positive for single in alone])
    wrong = positive[:, None] & (first_size < 0.0)
    worth[wrong | wrong.T] = NOTHING
    rows, others = np.triu_indices(len(alone), 1)
    offers = [
        (float(worth[row, other]), alone[row], alone[other])
        for row, other in zip(rows.tolist(), others.tolist(), strict=True)
        if worth[row, other] > 0.0 and terms[alone[row]].key != terms[alone[other]].key
    ]
    for _, first, second in sorted(offers, reverse=True)[:3]:
        pair = tuple(sorted((*beside.members, first, second)))
        if posterior.evidence(pair) > least and all(
            posterior.beside(tuple(other for other in pair if other != single)).judge(single).worth > 0.0
            for single in (first, second)
        ):
            return first, second
    return None


def _thinned(posterior: Posterior, members: Members) -> Members:
    """Return a set without the members that are not worth staying beside the others.

    Of those that nobody believes in together, the likelier stay.
    """
    members = _without_what_cancels(posterior, _without_leftovers(posterior, members))
    sure: set[int] = set()
    while members:
        judged = [single for single in members if single not in sure]
        worths = {single: posterior.beside(set(members) - {single}).judge(single).worth for single in judged}
        worst = min(worths, key=lambda single: worths[single], default=None)
        if worst is None or worths[worst] > 0.0:
            return members
        if worths[worst] == NOTHING:
            rests = {single: posterior.evidence(set(members) - {single}) for single in members}
            worst = max(rests, key=lambda single: rests[single])
        members = tuple(single for single in members if single != worst)
        # what is sure beside more than is there now is judged once: leaving others only makes it surer
        sure |= {single for single, worth in worths.items() if worth > SURE}
    return members


def _without_leftovers(posterior: Posterior, members: Members) -> Members:
    """Return a set without pushes beside events that have a name: no law of an event is exact."""
    terms = posterior.terms
    named = [terms[single] for single in members if not is_push(terms[single])]
    return tuple(
        single
        for single in members
        if not (is_push(terms[single]) and _is_left(posterior, terms[single], named))
    )


def _without_what_cancels(posterior: Posterior, members: Members) -> Members:
    """Return a set without effects of one kind on several components, if it is likelier without all of them.

    Of an effect that is relative, such as a delay, a common amount on all components is none: each is needed
    given the others, and none alone. And where all but one have it, that one would have the opposite, which
    no component has.
    """
    terms = posterior.terms
    for kind in (kind.name for kind in EFFECTS if kind.relative):
        late = {terms[single].component for single in members if terms[single].effect == kind}
        prompt = {term.component for term in terms if term.effect == kind} - late
        if len(late) > 1 and len(prompt) <= 1:
            members = tuple(single for single in members if terms[single].effect != kind)
    for effect in sorted({posterior.terms[single].effect for single in members}):
        rest = tuple(single for single in members if posterior.terms[single].effect != effect)
        if len(members) - len(rest) > 1 and posterior.evidence(rest) > posterior.evidence(members):
            members = rest
    return members


def _exchanged(posterior: Posterior, members: Members) -> Members:
    """Return a set with members exchanged for candidates that are worth more in their place."""
    for old in members:
        if old not in members:
            continue
        rest = tuple(single for single in members if single != old)
        beside = posterior.beside(rest)
        pair = (
            None if posterior.terms[old].is_event else _pair(posterior, beside, posterior.evidence(members))
        )
        if pair is not None:
            members = tuple(sorted({*rest, *pair}))
            continue
        offer = _instead(posterior, beside, old) if posterior.terms[old].is_event else best(posterior, beside)
        if offer is None or offer[0] == old:
            continue
        own = beside.judge(old)
        if not believable(posterior, offer[0], offer[1], old, own):
            continue
        if offer[1].worth > 0.0 and offer[1].rank > own.rank:
            members = tuple(sorted({*rest, offer[0]}))
    return members


def _joined(posterior: Posterior, members: Members) -> Members:
    """Return a set with two members exchanged for a single candidate, if the set is then likelier."""
    for first, second in itertools.combinations(members, 2):
        for single, gain in instead_of_two(posterior, members, first, second):
            beside = posterior.beside(set(members) - {first, second})
            if gain > 0.0 and beside.judge(single).worth > 0.0:
                return tuple(sorted({*beside.members, single}))
    return members


def instead_of_two(
    posterior: Posterior, members: Members, first: int, second: int
) -> list[tuple[int, float]]:
    """Return what lasts and may stand in the place of two members, and how much likelier the set then is.

    Two effects may each explain a part of what is a third one, of what has no name and acts on the same
    component, or, while they act, of a push. The likeliest come first. A name must be worth something there;
    what has no name, and may be too small to be told, counts against the names all the same.
    """
    terms, rest = posterior.terms, set(members) - {first, second}
    events = terms[first].is_event and terms[second].is_event  # what lasts is offered in the place of each
    taken = {terms[single].key for single in rest}
    parts = terms[first].component, terms[second].component
    offers = [
        single
        for single, term in enumerate(terms)
        if (_pushes_both(term, terms[first], terms[second]) if term.is_local else not events)
        and term.key not in taken
        and single not in members
        and (term.probes or all(part.startswith(term.component) for part in parts))
    ]
    if not offers:
        return []
    beside, whole = posterior.beside(rest), posterior.evidence(members)
    gains = [
        (single, posterior.evidence({*rest, single}) - whole)
        for single in offers
        if beside.quick(single) > 0.0
    ]
    likeliest = sorted(gains, key=lambda offer: -offer[1])[:OFFERS]
    return [offer for offer in likeliest if not terms[offer[0]].probes or beside.judge(offer[0]).worth > 0.0]


def _pushes_both(term: Term, first: Term, second: Term) -> bool:
    """Say whether a candidate is a push while two events with names act: they may share what is a push."""
    return (
        is_push(term)
        and not (is_push(first) or is_push(second))
        and overlap(term.stretches, first.stretches)
        and overlap(term.stretches, second.stretches)
    )


def _instead(posterior: Posterior, beside: Beside, old: int) -> tuple[int, Judgement] | None:
    """Return the event at the same moments that is worth most in the place of another."""
    terms = posterior.terms
    times = terms[old].fixed["times"]
    near = [
        single
        for single, term in enumerate(terms)
        if term.is_event
        and single not in beside.members
        and len(term.fixed["times"]) == len(times)
        and all(abs(time - own) < APART for time, own in zip(times, term.fixed["times"], strict=True))
    ]
    return _first(list(zip(near, beside.judge_all(near), strict=True)))
