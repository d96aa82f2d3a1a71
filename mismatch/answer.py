"""From a search and its refined effects to the answer: findings in words, residuals, what is left."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omnimate.mismatch.choose import EMPTY, decoded, inclusion, rivals
from omnimate.mismatch.diagnosis import (
    ASSERTED,
    Alternative,
    Change,
    Diagnosis,
    Finding,
    Fit,
    Parameter,
    Where,
)
from omnimate.mismatch.doubt import believed, is_something
from omnimate.mismatch.evidence import evidence_of
from omnimate.mismatch.heldout import HELD, METRIC, held_out, size
from omnimate.mismatch.instead import contradicted, dwarfed, nameless, truck_of
from omnimate.mismatch.refine import TURNS, keeping
from omnimate.mismatch.regression import Regression
from omnimate.mismatch.rerun import rerun
from omnimate.mismatch.signals import WINDOW
from omnimate.mismatch.uncertainty import sigmas
from omnimate.mismatch.where import channels_of, crossings, laps_at, places_at, row_names
from omnimate.mismatch.words import drives_for, part, regime, sentence, separating

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.mismatch.choose import Choice
    from omnimate.mismatch.diagnosis import Key
    from omnimate.mismatch.heldout import HeldOut
    from omnimate.mismatch.investigate import Investigation
    from omnimate.mismatch.refine import Refined
    from omnimate.mismatch.terms import Term
    from omnimate.vcan_sim.effects.effect import Effect

_SHOWN = 6  # alternatives of a finding
_MAYBE = 0.2  # probability from which something is there, though none of its names may be asserted
_LOUD = 1.3  # times the sensors' noise, a residual with which nobody may say that all agrees
_NEEDLESS = 10.0  # log units that an effect has to be worth beside something unknown on its component
POSSIBLE = 0.01  # probability below which an alternative is not worth a word
# What a drive must be able to show before "agreement" means something: coefficients with a standard
# deviation of less than this share of what robots in use are off by.
_SEEN = 0.7
_NEEDED = ("wheelbase", "wheel_diameter")


def answer(found: Investigation, refined: Refined, turns: int = TURNS) -> Diagnosis:
    """Return the diagnosis; only effects that are told are in the fit and in the effects file.

    Args:
        found: what the search came to.
        refined: the best set's effects.
        turns: of Gauss-Newton, where some of these are not told and the others are fitted anew.
    """
    named = _findings(found, refined)
    refined = keeping(found, refined, {one.key for one in named}, turns)
    fitted = refined.regression
    nominal = Regression(fitted.windows, fitted.noise, (), fitted.folds)
    residuals = held_out(nominal, refined)
    fit = _fit(fitted, residuals)
    excess = max(_excess(nominal.white[:, 0]), 1e-9)
    unexplained = min(1.0, max(0.0, _excess(residuals.train)) / excess)
    findings = _ordered(dwarfed(contradicted(named, fit), unexplained))
    signals = found.regression.windows[0].signals
    names = tuple(one.signals.recording.source for one in found.regression.windows)
    left = unexplained if findings else 0.0
    nothing = found.choice.probabilities().get(EMPTY, 0.0)
    blind = _blind(found)
    robot = signals.recording.vehicle.name
    evidence = evidence_of(found, refined, nominal, residuals, findings)
    if nothing < 1.0 - ASSERTED and any(_told(one) >= _MAYBE for one in findings):
        says = _headline(findings, fit)
        advice = tuple(dict.fromkeys(one.separates for one in findings if one.separates))
        unknown = [one for one in findings if one.effect == "unknown"]
        depends = tuple(dict.fromkeys(quantity for one in unknown for quantity in one.depends_on))
        return Diagnosis(
            "mismatch", says, findings, fit, left, depends, robot, names, advice, evidence, refined.effects
        )
    if blind:
        drives = drives_for(sorted({effect for effect, _ in blind}))
        what = ", ".join(
            f"the {effect.replace('_', ' ')} of {part(component)}" for effect, component in blind[:4]
        )
        says = f"Nothing stands out, but this drive cannot show {what}. Drive: {'; '.join(drives)}."
        return Diagnosis("insufficient", says, findings, fit, left, (), robot, names, drives, evidence)
    says = "Simulation and recording agree: nothing is left beyond the noise of sensors and floor."
    return Diagnosis("agreement", says, findings, fit, left, (), robot, names, (), evidence)


def _told(finding: Finding) -> float:
    """Return how probable it is that a finding, or what stands in its place, is there at all."""
    return finding.probability + sum(one.probability for one in finding.alternatives)


def _excess(rows: np.ndarray[tuple[int], np.dtype[np.float64]]) -> float:
    """Return the chi-square beyond that of noise."""
    return float(rows @ rows) - len(rows)


def _findings(found: Investigation, refined: Refined) -> tuple[Finding, ...]:
    """Return the members of the best set as findings; where none is believed and it is loud, one unknown."""
    probable = inclusion(found.choice)
    lines = found.untolerant()
    whole = max(lines.explained(found.chosen), 1e-9)
    findings = []
    numbers = {term.key: number for number, term in enumerate(refined.terms)}
    for member in sorted(found.chosen):
        term = found.choice.terms[member]
        others = tuple(
            Alternative(*key, probability=share)
            for key, share in rivals(found.choice, found.chosen, member)[:_SHOWN]
            if share >= POSSIBLE
        )
        if term.effect == "unknown":
            findings.append(_unknown(found, lines, member, probable[term.key], others, whole))
        elif term.key in numbers and is_something(refined, numbers[term.key]):
            findings.append(_finding(refined, numbers[term.key], probable[term.key], others, whole))
    told = believed(findings, refined, whole, _dispensable(found))
    if findings and not told and size(found.regression.white[:, 0]) > _LOUD:
        return (nameless(findings, _shaken(found)),)
    return told


def _shaken(found: Investigation) -> str:
    """Return the truck without whose effects the best set is worth least."""
    choice, chosen = found.choice, found.chosen

    def without(truck: str) -> float:
        rest = {one for one in chosen if truck_of(choice.terms[one].component) != truck}
        return choice.worth(frozenset(rest))

    return min({truck_of(one.component) for one in found.members()}, key=without)


def _dispensable(found: Investigation) -> set[Key]:
    """Return the named effects of the best set that its unknown on the same component could stand for."""
    choice, chosen = found.choice, found.chosen
    strange = {
        term.component for term in found.members() if term.effect == "unknown" and not term.fixed["moments"]
    }
    return {
        choice.terms[one].key
        for one in chosen
        if choice.terms[one].effect != "unknown"
        and choice.terms[one].component in strange
        and choice.worth(chosen - {one}) > choice.worth(chosen) - _NEEDLESS
    }


def _finding(
    refined: Refined, number: int, probability: float, others: tuple[Alternative, ...], whole: float
) -> Finding:
    term, effect = refined.terms[number], refined.effects[number]
    own = refined.regression.white[:, refined.places[number]]
    part_of = own @ refined.values[number]
    without = refined.regression.white[:, 0] + part_of
    drop = float(without @ without - refined.regression.white[:, 0] @ refined.regression.white[:, 0])
    signals = [one.signals for one in refined.regression.windows]
    vehicle = signals[0].recording.vehicle
    intervals = crossings(effect, signals)
    separates = ""
    if any(one.probability > 0.05 for one in others):
        separates = separating([effect.name, *(one.effect for one in others)])
    return Finding(
        effect.name,
        effect.component,
        min(probability, 0.999),
        others,
        Where(
            channels_of(refined.regression, part_of),
            intervals,
            regime(effect),
            laps_at(intervals, signals),
            places_at(intervals, signals),
        ),
        _parameters(term, effect, refined, number),
        min(1.0, max(0.0, drop / whole)),
        sentence(effect, vehicle),
        (),
        separates,
    )


def _parameters(term: Term, effect: Effect, refined: Refined, number: int) -> tuple[Parameter, ...]:
    known = sigmas(term, effect, refined.covariances[number])
    for name, spread in refined.loose[number].items():
        known[name] = spread if name == "times" else spread[0]
    return tuple(
        Parameter(spec.name, getattr(effect, spec.name), known.get(spec.name, 0.0), spec.unit)
        for spec in effect.parameters
        if spec.name != "intervals"
    )


def _unknown(
    found: Investigation,
    lines: Choice,
    member: int,
    probability: float,
    others: tuple[Alternative, ...],
    whole: float,
) -> Finding:
    """Return a finding that no effect of the library explains."""
    term, chosen = lines.terms[member], found.chosen
    own = next(values for one, values, _ in decoded(lines, chosen) if one == member)
    part_of = found.regression.white[:, lines.places[member]] @ own
    quantity = term.fixed["quantity"]
    return Finding(
        "unknown",
        term.component,
        min(probability, 0.999),
        others,
        Where(channels_of(found.regression, part_of), _around(term.fixed["moments"]), quantity),
        (),
        min(1.0, max(0.0, (lines.explained(chosen) - lines.explained(chosen - {member})) / whole)),
        f"Something that no effect of the library explains acts on {part(term.component)}: "
        f"what is left depends on {quantity}.",
        (quantity,),
        "",
    )


def _ordered(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """Return findings with what is asserted first, and most of the mismatch first among these."""
    return tuple(sorted(findings, key=lambda one: (one.probability < ASSERTED, -one.explained)))


def _around(moments: Sequence[float]) -> tuple[tuple[float, float], ...]:
    """Return the windows [s] that end at moments."""
    return tuple(sorted((moment, moment + WINDOW) for moment in moments))


def _fit(fitted: Regression, residuals: HeldOut) -> Fit:
    names = row_names(fitted.windows[0])
    channels = {}
    for number, name in enumerate(names):
        mine = fitted.channel == number
        if mine.any():
            channels[name] = Change(size(residuals.before[mine]), size(residuals.after[mine]))
    gain = residuals.gain
    spread = float(gain.std(ddof=1) * np.sqrt(len(gain))) if len(gain) > 1 else 0.0
    return Fit(
        METRIC.format(HELD[residuals.kind]),
        Change(size(residuals.before), size(residuals.train)),
        Change(size(residuals.before), size(residuals.after)),
        channels,
        (float(gain.sum()), spread),
        rerun(fitted, residuals),
        fitted.noise.named(),
    )


def _headline(findings: Sequence[Finding], fit: Fit) -> str:
    first = findings[0]
    what = (
        f"unknown physics on {part(first.component)}" if first.effect == "unknown" else first.says.rstrip(".")
    )
    maybe = "" if first.probability >= ASSERTED else "Perhaps: "
    more = f", and {len(findings) - 1} more" if len(findings) > 1 else ""
    return (
        f"{maybe}{what}{more}. Residual on data that no fit has seen: {fit.heldout.before:.2f} before, "
        f"{fit.heldout.after:.2f} after (1.00 is the sensors' own noise)."
    )


def _blind(found: Investigation) -> list[Key]:
    """Return which of an owner's numbers this drive would not show to be wrong, were they."""
    blind = []
    total = found.regression.total
    for number, term in enumerate(found.choice.terms):
        if term.effect in _NEEDED:
            place = found.choice.places[number].start
            if 1.0 / np.sqrt(total[place, place] + 1.0) > _SEEN:
                blind.append(term.key)
    return blind
