"""What is told instead of names that are not believed."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from omnimate.mismatch.choose import EVENTS
from omnimate.mismatch.diagnosis import ASSERTED, Alternative, Finding, Where
from omnimate.mismatch.terms import MOMENTS
from omnimate.mismatch.words import part

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from omnimate.mismatch.diagnosis import Fit

HOLLOW = 0.4  # of the probability of effects that are large and cancel, or that the unknown could replace
CROWD = 3  # findings of bumps and slips on one truck, or events of each, from which it is something else
ACROSS = 1.0  # [s] between the wheels of a truck that crosses an obstacle
DWARF = 0.5  # of what no named effect explains: what explains less may be of that making
ECHO = 0.25  # of the strongest unknown: what explains less is likewise
WORSE = 1.2  # times the nominal robot's open-loop miss, which chance does not reach


def gathered(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Return findings with a crowd of bumps and slips under both wheels of a truck told as what shoves it."""
    told = tuple(findings)
    for truck in ("a", "b"):
        events = [one for one in told if one.effect in EVENTS and truck_of(one.component) == truck]
        many = len(events) >= CROWD or all(len(one.where.intervals) >= CROWD for one in events)
        if not many or len({one.component for one in events}) < 2 or _together(events):
            continue
        unknown = nameless(
            events, truck, "bumps and slips under both of its wheels only imitate it", "shoves"
        )
        shoved = replace(
            unknown,
            probability=(1.0 - HOLLOW) * unknown.probability,
            alternatives=tuple(
                Alternative(one.effect, one.component, HOLLOW * one.probability / len(events))
                for one in events
            ),
            explained=min(1.0, sum(one.explained for one in events)),
        )
        told = _joined([one for one in told if one not in events], shoved)
    return told


def _joined(findings: Sequence[Finding], shoved: Finding) -> tuple[Finding, ...]:
    """Return findings with one more that is unknown, in one with what else is unknown on its truck."""
    same = [one for one in findings if one.key == shoved.key]
    both = replace(
        shoved,
        probability=max(one.probability for one in (*same, shoved)),
        explained=min(1.0, sum(one.explained for one in (*same, shoved))),
        depends_on=tuple(dict.fromkeys(quantity for one in (shoved, *same) for quantity in one.depends_on)),
    )
    return (*(one for one in findings if one not in same), both)


def _together(events: Sequence[Finding]) -> bool:
    """Say whether both wheels of a truck meet something at the same moments, as a cable across their way."""
    one, other = (
        [start for own in events if own.component.endswith(side) for start, _ in own.where.intervals]
        for side in ("left", "right")
    )
    few, many = sorted((one, other), key=len)
    return all(any(abs(start - then) < ACROSS for then in many) for start in few)


def contradicted(findings: Sequence[Finding], fit: Fit) -> tuple[Finding, ...]:
    """Return findings with less probability where the simulator that has them leads farther astray.

    What stands for a few windows and not for ten seconds is not understood: where the strongest of them is
    no longer asserted, something unknown acts there, and the name is an alternative.
    """
    ratios = [one.after / one.before for one in fit.rerun.values() if one.before > 0.0]
    worst = math.sqrt(sum(one**2 for one in ratios) / len(ratios)) if ratios else 1.0
    if worst <= WORSE:
        return tuple(findings)
    doubted = tuple(
        one if one.effect == "unknown" else replace(one, probability=one.probability / worst**2)
        for one in findings
    )
    strongest = max(findings, key=lambda one: one.explained, default=None)
    if strongest is None or any(one.effect == "unknown" for one in findings):
        return doubted
    taken = strongest.probability * (1.0 - 1.0 / worst**2)
    if strongest.probability - taken >= ASSERTED or taken < ASSERTED:
        return doubted
    others = (told for told, one in zip(doubted, findings, strict=True) if one is not strongest)
    return (_unknown_instead(strongest, taken), *others)


def dwarfed(findings: Sequence[Finding], left: float) -> tuple[Finding, ...]:
    """Return findings with less probability where they explain less than half of what nobody does.

    What else is unknown, and much weaker, is how the strongest unknown looks from elsewhere.

    Args:
        findings: to tell.
        left: share of the mismatch that no named effect explains.
    """
    strange = max((one.explained for one in findings if one.effect == "unknown"), default=0.0)
    return tuple(
        replace(one, probability=HOLLOW * one.probability)
        if one.explained < (ECHO * strange if one.effect == "unknown" else DWARF * left)
        else one
        for one in findings
    )


def nameless(
    findings: Sequence[Finding],
    truck: str,
    why: str = "what comes nearest to it falls far short",
    does: str = "acts on",
) -> Finding:
    """Return one unknown finding for all that were found and not believed.

    Args:
        findings: none of which is worth telling.
        truck: on which most of it is; "link" or "poses" where it is on neither.
        why: they are not, in words.
        does: what it does to the truck, likewise.
    """
    mine = [one for one in findings if truck_of(one.component) == truck] or list(findings)
    spans = tuple(sorted(span for one in mine for span in one.where.intervals))
    return Finding(
        "unknown",
        truck,
        max(one.probability for one in mine),
        (),
        Where(mine[0].where.channels, spans, MOMENTS if spans else mine[0].where.regime),
        (),
        1.0,
        f"Something that no effect of the library explains {does} {part(truck)}: {why}.",
        (MOMENTS,) if spans else (),
    )


def _unknown_instead(finding: Finding, taken: float) -> Finding:
    """Return a finding without a name for one that is not believed, with the probability taken from it."""
    name, where = finding.effect.replace("_", " "), part(finding.component)
    return Finding(
        "unknown",
        finding.component,
        taken,
        (Alternative(finding.effect, finding.component, finding.probability - taken),),
        finding.where,
        (),
        finding.explained,
        f"Something that no effect of the library explains acts on {where}. It looks like {name} from moment "
        f"to moment, but a simulator with that {name} leads farther astray than one without.",
        (finding.where.regime,),
    )


def truck_of(component: str) -> str:
    """Return the truck that a component is a part of; itself for what is of both."""
    return component.removeprefix("joint_").partition(".")[0]
