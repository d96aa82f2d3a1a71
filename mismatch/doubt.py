"""What to make of findings that are small, hollow, in another one's shadow, or worse in the open loop.

The evidence weighs sets of effects as the library models them. What a model of a large effect leaves
looks like further, small ones; the rules here keep those from being told.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from omnimate.mismatch.choose import EVENTS
from omnimate.mismatch.instead import HOLLOW, gathered, nameless, truck_of
from omnimate.mismatch.signals import WINDOW
from omnimate.mismatch.terms import SCANNED

if TYPE_CHECKING:
    from collections.abc import Sequence
    from collections.abc import Set as AbstractSet

    from omnimate.mismatch.diagnosis import Finding, Key
    from omnimate.mismatch.refine import Refined
    from omnimate.vehicle.se2 import Array

LEAST = 0.004  # of the mismatch: what explains less may be the way in which a big effect is modelled
PLAIN = 100.0  # of chi-square: what explains as much is there, however large another one is
LEAST_EVENT = 0.015  # likewise of what is looked for at every moment
FAINT = 0.01  # of all rows' chi-square: an unknown that explains less is how no model is perfect
FAINTEST = 60.0
FAINT_UNKNOWN = 0.04  # share of the mismatch: an unknown below it is the imperfection of every model
TRACE = 0.015  # of what a stronger one on the same truck explains: nobody can tell such a finding from it
CURVED = 0.05  # likewise of an unknown that could do without the named effect beside it
SHAPE = 0.15  # of what a named effect explains may be left by the way in which it is modelled
EDGE = 0.5  # likewise, at the very moments at which that effect acts
STAND_IN = 4.0  # a named effect takes so many times as much of an unknown one as it leaves
UNUSUAL = 2.0  # a-priori sizes beyond which an effect is large
OPPOSED = 0.8  # cosine of two effects that nearly cancel
ALIKE = 0.5  # of the larger of two such effects, the smaller at least
SHADOW = 3.0  # [s] about an unknown moment, in which what is weaker belongs to it
CHANCE = 6.0  # chi-square of each coefficient, below which an effect may be none
_MANY = 6


def believed(
    findings: Sequence[Finding], refined: Refined, whole: float, dispensable: AbstractSet[Key] = frozenset()
) -> tuple[Finding, ...]:
    """Return the findings that are worth telling, with what doubts leave of their probabilities.

    Args:
        findings: members of the best set.
        refined: its effects.
        whole: chi-square that the best set takes away.
        dispensable: effects in whose place the unknown of the same component does as well.
    """
    faint = max(FAINT * len(refined.regression.white), FAINTEST)
    worth = gathered(
        one
        for one in findings
        if _counts(one, whole)
        and not (one.effect == "unknown" and (one.explained * whole < faint or one.explained < FAINT_UNKNOWN))
        and not _in_the_shape(one, findings, dispensable)
        and not _overshadowed(one, findings)
        and not _folded(one, findings)
    )
    strange = {one.component for one in worth if one.effect == "unknown"}
    opposed = {refined.terms[number].key for number in _cancelling(refined)}
    hollow = opposed | {(effect, component) for effect, component in dispensable if component in strange}
    told = [
        replace(known, probability=HOLLOW * known.probability) if known.key in hollow else known
        for known in (_doubted(one, worth) for one in worth)
    ]
    return (*told, *_instead([one for one in worth if one.key in opposed], strange))


def _instead(opposed: Sequence[Finding], strange: AbstractSet[str]) -> list[Finding]:
    """Return what is unknown where effects on one truck cancel, unless something unknown is told of it."""
    trucks = {truck_of(one.component) for one in opposed}
    if len(trucks) != 1 or trucks & {truck_of(one) for one in strange}:
        return []
    unknown = nameless(opposed, next(iter(trucks)), "large effects that cancel imitate it")
    return [replace(unknown, probability=(1.0 - HOLLOW) * unknown.probability)]


def _counts(finding: Finding, whole: float) -> bool:
    """Say whether a finding explains enough of a mismatch of some chi-square to be more than its shape."""
    if finding.effect in SCANNED:
        return finding.explained >= LEAST_EVENT
    return finding.explained >= LEAST or finding.explained * whole >= PLAIN


def is_something(refined: Refined, number: int) -> bool:
    """Say whether an effect is still there when it was fitted with all others, as it really is."""
    values, covariance = refined.values[number], refined.covariances[number]
    if refined.terms[number].positive and np.all(values <= 0.0):
        return False
    return float(values @ np.linalg.solve(covariance, values)) > CHANCE * len(values)


def _cancelling(refined: Refined) -> set[int]:
    """Return the effects that nearly cancel, two on one component or any far larger than usual.

    Two curves of the library in a difference make a third one, which is none of the library's. A floor
    that slopes is under both trucks, and the linkage sees the difference only.
    """
    parts = [
        refined.regression.white[:, place] @ values
        for place, values in zip(refined.places, refined.values, strict=True)
    ]
    large = [bool(np.linalg.norm(values) > UNUSUAL) for values in refined.values]
    found: set[int] = set()
    for first, second in combinations(range(len(parts)), 2):
        one, other = refined.terms[first], refined.terms[second]
        if one.effect == other.effect == "floor_slope":
            continue
        if one.component != other.component and not (large[first] and large[second]):
            continue
        if _opposed(parts[first], parts[second]):
            found |= {first, second}
    trucks = [truck_of(one.component) for one in refined.terms]
    for number in np.flatnonzero(large).tolist():
        rest = [at for at in range(len(parts)) if at != number and trucks[at] == trucks[number]]
        if len(rest) > 1 and _opposed(parts[number], np.sum([parts[at] for at in rest], axis=0)):
            found |= {number, *rest}
    return found


def _opposed(one: Array, other: Array) -> bool:
    """Say whether what an effect does is nearly the opposite of what another does, and as large."""
    few, many = sorted((float(np.linalg.norm(one)), float(np.linalg.norm(other))))
    return few > ALIKE * many and float(one @ other) < -OPPOSED * few * many


def _in_the_shape(finding: Finding, findings: Sequence[Finding], dispensable: AbstractSet[Key]) -> bool:
    """Say whether a finding is what the model of a stronger one on the same truck leaves."""
    return any(
        finding.explained < _limit(finding, other, dispensable) * other.explained
        for other in findings
        if other is not finding and truck_of(other.component) == truck_of(finding.component)
    )


def _limit(finding: Finding, other: Finding, dispensable: AbstractSet[Key]) -> float:
    """Return the part of what another finding explains, below which this one is of its making."""
    alike = finding.component == other.component
    edged = finding.effect in SCANNED and other.effect in SCANNED | {"count_loss"} and alike
    elsewhere = bool(finding.where.intervals and other.where.intervals) and not _meet(finding, other)
    if other.effect == "floor_slope" != finding.effect:
        return SHAPE  # no floor slopes evenly
    if other.effect == "unknown" or not (finding.effect == "unknown" or (edged and not elsewhere)):
        return TRACE
    if _touch(finding, other):
        return EDGE
    return CURVED if other.key in dispensable else SHAPE


def _touch(finding: Finding, other: Finding) -> bool:
    """Say whether all that a finding is made of lies at the moments of another one."""
    return bool(finding.where.intervals) and all(_met_by(span, other) for span in finding.where.intervals)


def _meet(finding: Finding, other: Finding) -> bool:
    """Say whether two findings ever act at the same moment."""
    return any(_met_by(span, other) for span in finding.where.intervals)


def _met_by(span: tuple[float, float], other: Finding) -> bool:
    """Say whether a finding acts in a stretch of time [s], or next to it."""
    start, end = span
    return any(start < last + WINDOW and end > first - WINDOW for first, last in other.where.intervals)


def _doubted(finding: Finding, findings: Sequence[Finding]) -> Finding:
    """Return a finding with its probability lowered by what stays unknown on its own component.

    Where no effect of the library does, the one that comes nearest does some of the work.
    """
    strange = max(
        (other.explained for other in findings if other.effect == "unknown" and _on(finding, other)),
        default=0.0,
    )
    if finding.effect == "unknown" or strange <= SHAPE * finding.explained:
        return finding
    share = finding.explained / (finding.explained + STAND_IN * strange)
    return replace(finding, probability=finding.probability * share)


def _on(finding: Finding, other: Finding) -> bool:
    """Say whether a finding is on another one's component, truck, or side."""
    if finding.component == other.component or truck_of(finding.component) == truck_of(other.component):
        return True
    return finding.effect in EVENTS and finding.component.endswith(f".{other.component}")


def _folded(finding: Finding, findings: Sequence[Finding]) -> bool:
    """Say whether a finding is unknown where something stronger is unknown on the same truck."""
    return finding.effect == "unknown" and any(
        other.effect == "unknown"
        and other.explained > finding.explained
        and truck_of(other.component) == truck_of(finding.component)
        for other in findings
    )


def _overshadowed(finding: Finding, findings: Sequence[Finding]) -> bool:
    """Say whether a finding is a part of something stronger and unknown that acts at the same moments.

    What shoves a robot about shows as bumps and slips of its wheels, too.
    """
    if not finding.where.intervals or len(finding.where.intervals) > _MANY:
        return False
    stronger = [
        interval
        for other in findings
        if other.effect == "unknown" and other is not finding and other.explained > finding.explained
        for interval in other.where.intervals
    ]
    return all(
        any(start < last + SHADOW and end > first - SHADOW for first, last in stronger)
        for start, end in finding.where.intervals
    )
