"""From a search and its refined effects to the answer: findings in words, residuals, what is left."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from mismatch.choose import EMPTY, EVENTS, inclusion, rivals
from mismatch.diagnosis import ASSERTED, Alternative, Change, Diagnosis, Finding, Fit, Parameter, Where
from mismatch.evidence import evidence_of
from mismatch.heldout import HELD, METRIC, held_out, size
from mismatch.refine import sigmas
from mismatch.regression import Regression
from mismatch.rerun import rerun
from mismatch.signals import WINDOW
from mismatch.terms import SCANNED
from mismatch.where import channels_of, crossings, laps_at, places_at, row_names
from mismatch.words import drives_for, part, regime, sentence, separating

if TYPE_CHECKING:
    from collections.abc import Sequence

    from mismatch.heldout import HeldOut
    from mismatch.investigate import Investigation
    from mismatch.refine import Refined
    from mismatch.terms import Term
    from vcan_sim.effects.effect import Effect

POSSIBLE = 0.01  # probability below which an alternative is not worth a word
LEAST = 0.004  # of the mismatch: what explains less may be the way in which a big effect is modelled
TRACE = 0.01  # of what a stronger one on the same component explains: nobody can tell such a finding from it
LEAST_EVENT = 0.015  # likewise of what is looked for at every moment
SHAPE = 0.15  # of what a named effect explains may be left by the way in which it is modelled
EDGE = 0.5  # likewise, at the very moments at which that effect acts
STAND_IN = 4.0  # a named effect takes so many times as much of an unknown one as it leaves
UNUSUAL = 2.0  # a-priori sizes beyond which an effect is large
OPPOSED = 0.8  # cosine of two effects that nearly cancel
HOLLOW = 0.4  # of the probability of effects that are large and cancel
SHADOW = 3.0  # [s] about an unknown moment, in which what is weaker belongs to it
FAINT = 0.01  # of all rows' chi-square: an unknown that explains less is how no model is perfect
FAINTEST = 60.0
STRANGE = 0.04  # of the mismatch: an unknown that explains less than this is how no model is perfect
CHANCE = 4.0  # chi-square of each coefficient, below which an effect may be none
WORSE = 1.2  # times the nominal robot's open-loop miss, which chance does not reach
_MANY = 6
# What a drive must be able to show before "agreement" means something: coefficients with a standard
# deviation of less than this share of what robots in use are off by.
_SEEN = 0.7
_NEEDED = ("wheelbase", "wheel_diameter")


def answer(found: Investigation, refined: Refined) -> Diagnosis:
    """Return the diagnosis."""
    fitted = refined.regression
    nominal = Regression(fitted.windows, fitted.noise, (), fitted.folds)
    residuals = held_out(nominal, refined)
    fit = _fit(fitted, residuals)
    findings = _ordered(_contradicted(_findings(found, refined, nominal), fit))
    signals = found.regression.windows[0].signals
    names = tuple(one.signals.recording.source for one in found.regression.windows)
    excess = max(_excess(nominal.white[:, 0]), 1e-9)
    left = min(1.0, max(0.0, _excess(residuals.train)) / excess) if findings else 0.0
    nothing = found.choice.probabilities().get(EMPTY, 0.0)
    blind = _blind(found)
    robot = signals.recording.vehicle.name
    evidence = evidence_of(found, refined, nominal, residuals, findings)
    if findings and nothing < 1.0 - ASSERTED:
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


def _excess(rows: np.ndarray[tuple[int], np.dtype[np.float64]]) -> float:
    """Return the chi-square beyond that of noise."""
    return float(rows @ rows) - len(rows)


def _findings(found: Investigation, refined: Refined, nominal: Regression) -> tuple[Finding, ...]:
    """Return the members of the best set as findings."""
    probable = inclusion(found.choice)
    whole = _mismatch(found)
    findings = []
    numbers = {term.key: number for number, term in enumerate(refined.terms)}
    for member in sorted(found.chosen):
        term = found.choice.terms[member]
        others = tuple(
            Alternative(*key, probability=share)
            for key, share in rivals(found.choice, found.chosen, member)[:_MANY]
            if share >= POSSIBLE
        )
        if term.effect == "unknown":
            findings.append(_unknown(found, member, probable[term.key], others))
        elif term.key in numbers and _is_something(refined, numbers[term.key]):
            findings.append(_finding(refined, numbers[term.key], probable[term.key], others, whole))
    faint = max(FAINT * len(nominal.white), FAINTEST)
    worth = [
        one
        for one in findings
        if one.explained >= (LEAST_EVENT if one.effect in SCANNED else LEAST)
        and not (one.effect == "unknown" and (one.explained * whole < faint or one.explained < STRANGE))
        and not _in_the_shape(one, findings)
        and not _overshadowed(one, findings)
    ]
    hollow = {refined.terms[number].key for number in _cancelling(refined)}
    return tuple(
        replace(known, probability=HOLLOW * known.probability)
        if (known.effect, known.component) in hollow
        else known
        for known in (_doubted(one, worth) for one in worth)
    )


def _is_something(refined: Refined, number: int) -> bool:
    """Say whether an effect is still there when it was fitted with all others, as it really is."""
    values, covariance = refined.values[number], refined.covariances[number]
    return float(values @ np.linalg.solve(covariance, values)) > CHANCE * len(values)


def _cancelling(refined: Refined) -> set[int]:
    """Return the effects that are far larger than usual and nearly cancel one another.

    Two curves of the library in a difference make a third one, which is none of the library's.
    """
    parts = [
        refined.regression.white[:, place] @ values
        for place, values in zip(refined.places, refined.values, strict=True)
    ]
    large = [number for number, values in enumerate(refined.values) if np.linalg.norm(values) > UNUSUAL]
    found: set[int] = set()
    for first, second in combinations(large, 2):
        together = float(parts[first] @ parts[second])
        if together < -OPPOSED * float(np.linalg.norm(parts[first]) * np.linalg.norm(parts[second])):
            found |= {first, second}
    return found


def _mismatch(found: Investigation) -> float:
    """Return how much of the chi-square the best set takes away."""
    columns = found.choice.columns(found.chosen)
    total = found.regression.total
    coefficients, _ = found.choice.solved(found.chosen)
    products = total[np.ix_(columns, columns)]
    return max(float(2.0 * total[0, columns] @ coefficients - coefficients @ products @ coefficients), 1e-9)


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
    found: Investigation, member: int, probability: float, others: tuple[Alternative, ...]
) -> Finding:
    """Return a finding that no effect of the library explains."""
    term = found.choice.terms[member]
    columns = found.choice.columns([member])
    rest = found.chosen - {member}
    with_it, _ = found.choice.solved(found.chosen)
    everything = found.choice.columns(found.chosen)
    part_of = found.regression.white[:, columns] @ with_it[[everything.index(one) for one in columns]]
    base = found.choice.columns(rest)
    coefficients, _ = found.choice.solved(rest)
    before = found.regression.white[:, 0] - found.regression.white[:, base] @ coefficients
    after = found.regression.white[:, 0] - found.regression.white[:, everything] @ with_it
    whole = _mismatch(found)
    quantity = term.fixed["quantity"]
    return Finding(
        "unknown",
        term.component,
        min(probability, 0.999),
        others,
        Where(channels_of(found.regression, part_of), _around(term.fixed["moments"]), quantity),
        (),
        min(1.0, max(0.0, float(before @ before - after @ after) / whole)),
        f"Something that no effect of the library explains acts on {part(term.component)}: "
        f"what is left depends on {quantity}.",
        (quantity,),
        "",
    )


def _in_the_shape(finding: Finding, findings: Sequence[Finding]) -> bool:
    """Say whether a finding is what the model of a stronger one on the same component leaves."""
    if any(
        other.component == finding.component and finding.explained < TRACE * other.explained
        for other in findings
    ):
        return True
    return finding.effect in {"unknown", *SCANNED} and any(
        other.component == finding.component
        and finding.explained < (EDGE if _touch(finding, other) else SHAPE) * other.explained
        for other in findings
        if other.effect != "unknown" and (finding.effect == "unknown" or other.effect in SCANNED)
    )


def _touch(finding: Finding, other: Finding) -> bool:
    """Say whether all that a finding is made of lies at the moments of another one."""
    return bool(finding.where.intervals) and all(
        any(start < last + WINDOW and end > first - WINDOW for first, last in other.where.intervals)
        for start, end in finding.where.intervals
    )


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
    """Say whether a finding is on another one's component, or is an event on one of its two sides."""
    side = finding.effect in EVENTS and finding.component.endswith(f".{other.component}")
    return side or finding.component == other.component


def _contradicted(findings: Sequence[Finding], fit: Fit) -> tuple[Finding, ...]:
    """Return findings with less probability where the simulator that has them leads farther astray.

    What stands for a few windows and not for ten seconds is not understood.
    """
    worst = max((one.after / one.before for one in fit.rerun.values() if one.before > 0.0), default=1.0)
    if worst <= WORSE:
        return tuple(findings)
    return tuple(
        one if one.effect == "unknown" else replace(one, probability=one.probability / worst**2)
        for one in findings
    )


def _ordered(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """Return findings with what is asserted first, and most of the mismatch first among these."""
    return tuple(sorted(findings, key=lambda one: (one.probability < ASSERTED, -one.explained)))


def _around(moments: Sequence[float]) -> tuple[tuple[float, float], ...]:
    """Return the windows [s] that end at moments."""
    return tuple(sorted((moment, moment + WINDOW) for moment in moments))


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


def _blind(found: Investigation) -> list[tuple[str, str]]:
    """Return which of an owner's numbers this drive would not show to be wrong, were they."""
    blind = []
    total = found.regression.total
    for number, term in enumerate(found.choice.terms):
        if term.effect in _NEEDED:
            place = found.choice.places[number].start
            if 1.0 / np.sqrt(total[place, place] + 1.0) > _SEEN:
                blind.append(term.key)
    return blind
