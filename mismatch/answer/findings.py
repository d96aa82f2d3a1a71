"""Findings, each from a member of the best set: its probability, what else it may be, where, and in words."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from omnimate.effects.words import component_in_words
from omnimate.mismatch.answer.constancy import changing_error
from omnimate.mismatch.answer.doubts import EVEN, SUREST, surest_names, surest_unknown
from omnimate.mismatch.answer.repeats import repeats_of
from omnimate.mismatch.answer.rerun import STRETCH
from omnimate.mismatch.answer.rivals import POSSIBLE, rivalry
from omnimate.mismatch.answer.unseen import drives_for
from omnimate.mismatch.answer.where import crossings, where_of
from omnimate.mismatch.candidates.pushes import PUSH_REGIME
from omnimate.mismatch.candidates.terms import UNKNOWN
from omnimate.mismatch.diagnosis import ASSERTED, Alternative, Finding, Parameter, Where
from omnimate.mismatch.scans.nonlinear import spreads

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.effects.effect import Effect
    from omnimate.mismatch.answer.constancy import RollingError
    from omnimate.mismatch.answer.omnibus import Leftover
    from omnimate.mismatch.answer.rivals import Rivalry
    from omnimate.mismatch.candidates.regression import Regression
    from omnimate.mismatch.diagnosis import Key, Repeats
    from omnimate.mismatch.fit import Acting, Fitted
    from omnimate.mismatch.investigate import Investigation

_SHOWN = 6  # alternatives of a finding


def found(investigation: Investigation, left: Leftover, square: float, residual: float) -> list[Finding]:
    """Return what the members of the best set are.

    Args:
        investigation: The search.
        left: What its fit leaves.
        square: The square of the mismatch, of which each explains a share.
        residual: What is missed where no fit has seen it, 1 for noise.
    """
    fit, members = investigation.fit, investigation.members
    rows, chosen = fit.rows, fit.chosen
    parts = [rows[:, place] @ sizes for place, sizes in zip(chosen.places, chosen.values, strict=True)]
    explained = [float(part @ (part + 2.0 * rows[:, 0])) / square for part in parts]
    surest = surest_names(investigation, parts, rows[:, 0], explained, left, residual)
    surest_nameless = surest_unknown(investigation)
    numbers = {member: number for number, member in enumerate(investigation.named)}
    repeats = repeats_of(fit, len(numbers))
    return [
        _finding(
            fit, number, rivalry(investigation, member), explained[number], surest[number], repeats[number]
        )
        if (number := numbers.get(member)) is not None
        else _unknown(investigation, member, rivalry(investigation, member), square, surest_nameless)
        for member in members
    ]


def _finding(
    fit: Fitted, number: int, rivals: Rivalry, explained: float, surest: float, repeats: Repeats | None
) -> Finding:
    """Return an effect of the fit that explains a share, as a finding no surer than a probability."""
    effect, regression = fit.chosen.effects[number], fit.regression
    part_of = regression.white[:, fit.chosen.places[number]] @ fit.chosen.values[number]
    error = changing_error(fit, number)
    if error is not None:
        nameless = dict(rivals.rivals).get((UNKNOWN, effect.component), 0.0)
        probability = rivals.probability + nameless
        return _changing(effect, error, probability, explained, where_of(regression, part_of, (), "time"))
    signals = [windows.signals for windows in regression.windows]
    others = _alternatives(rivals, fit.chosen.terms[number].key, surest)
    names = [effect.name, *(other.effect for other in others)]
    unknown = effect.name == UNKNOWN
    if unknown:
        regime = PUSH_REGIME
        says = f"{component_in_words(effect.component)} was pushed at single moments, as no obstacle does."
    else:
        regime = effect.regime.format(component=effect.component, order=getattr(effect, "order", 1.0))
        says = effect.describe(signals[0].recording.vehicle)
    return Finding(
        effect.name,
        effect.component,
        min(rivals.probability, surest),
        others,
        where_of(regression, part_of, crossings(effect, signals), regime),
        () if unknown else parameters_of(fit.regression, fit.chosen, number),
        min(1.0, max(0.0, explained)),
        says[0].upper() + says[1:],
        (PUSH_REGIME,) if unknown else (),
        "; ".join(drives_for(names)) if any(other.probability > 0.05 for other in others) else "",
        repeats,
    )


def _alternatives(rivals: Rivalry, key: Key, surest: float) -> tuple[Alternative, ...]:
    """Return what may stand in a finding's place; what is doubted of its probability has no name."""
    shares = dict(rivals.rivals)
    unknown = UNKNOWN, key[1]
    if key != unknown:
        shares[unknown] = shares.get(unknown, 0.0) + max(0.0, rivals.probability - surest)
    likeliest = sorted(shares.items(), key=lambda pair: -pair[1])[:_SHOWN]
    return tuple(Alternative(*other, probability=share) for other, share in likeliest if share >= POSSIBLE)


def _changing(
    effect: Effect, error: RollingError, probability: float, explained: float, where: Where
) -> Finding:
    """Return a wheel's number that is not constant as a finding without a name."""
    return Finding(
        UNKNOWN,
        effect.component,
        min(probability, SUREST),
        (Alternative(effect.name, effect.component, min(1.0 - probability, EVEN)),),
        where,
        explained=min(1.0, max(0.0, explained)),
        says="Something that no effect of the library explains acts on "
        f"{component_in_words(effect.component)}: it rolls {error.begin:+.3%} more per turn than "
        f"vehicle.toml says at the beginning, and {error.end:+.3%} at the end.",
        depends_on=("time",),
    )


def _unknown(
    investigation: Investigation, member: int, rivals: Rivalry, square: float, surest: float
) -> Finding:
    """Return what has no name as a finding, with its law, no surer than a probability."""
    posterior = investigation.posterior
    term, fit = posterior.terms[member], investigation.fit
    conditional = posterior.given(set(investigation.members) - {member})
    judged = conditional.judge(member)
    part_of = conditional.residual_columns(list(posterior.candidates.columns(member))) @ judged.coefficients
    quantity = term.fixed["quantity"]
    laws = [
        effect for effect in fit.chosen.effects if effect.name == "law" and effect.component == term.component
    ]
    says = (
        f"Something that no effect of the library explains acts on {component_in_words(term.component)}: "
        f"what is left depends on {quantity}."
    )
    if laws:
        vehicle = investigation.signals[0].recording.vehicle
        says += f" A law was learned of it: {'; '.join(law.describe(vehicle) for law in laws)}."
    others = _alternatives(rivals, term.key, surest)
    return Finding(
        UNKNOWN,
        term.component,
        min(rivals.probability, surest),
        others,
        where_of(posterior.regression, part_of, (), quantity),
        (),
        min(1.0, float(part_of @ part_of) / square),
        says,
        (quantity,),
        "",
    )


def without_name(left: Leftover, present: Sequence[Finding], square: float) -> list[Finding]:
    """Return what is left and can be predicted, unless an error without a name was already found.

    Pushes at single moments are none: they do not last, and are often what an error that lasts looks like.
    """
    strongest = left.strongest
    lasting = (finding for finding in present if finding.where.regime != PUSH_REGIME)
    if strongest is None or any(finding.effect == UNKNOWN for finding in lasting):
        return []
    shown = strongest.shown
    missed = f"missed after {STRETCH:.0f} s of open loop" if shown.open_loop else "left"
    named = square if present else 0.0
    quantities = tuple(
        dict.fromkeys(
            prediction.quantity
            for prediction in left.predictions
            if prediction.component == strongest.component
        )
    )
    return [
        Finding(
            UNKNOWN,
            strongest.component,
            min(left.probability, SUREST),
            where=Where((shown.channel,), (), strongest.quantity),
            explained=strongest.gain / (strongest.gain + named),
            says="Something that no effect of the library explains acts on "
            f"{component_in_words(strongest.component)}: {shown.share:.0%} of what is {missed} on "
            f"{shown.channel} depends on {strongest.quantity}.",
            depends_on=quantities,
        )
    ]


def merged(findings: Sequence[Finding]) -> list[Finding]:
    """Return findings with all that is unknown on one component as one."""
    merged: dict[tuple[Key, str], Finding] = {}
    for finding in findings:
        name = finding.key, finding.where.regime if finding.effect == UNKNOWN else ""
        if name in merged:
            first, last = sorted((merged[name], finding), key=lambda one: -one.probability)
            where = replace(
                first.where,
                intervals=tuple(sorted({*first.where.intervals, *last.where.intervals})),
                places=(*first.where.places, *last.where.places),
                laps=tuple(sorted({*first.where.laps, *last.where.laps})),
            )
            merged[name] = replace(first, where=where, explained=min(1.0, first.explained + last.explained))
        else:
            merged[name] = finding
    return list(merged.values())


def parameters_of(regression: Regression, acting: Acting, number: int) -> tuple[Parameter, ...]:
    """Return the parameters of one of a fit's effects, with their standard deviations."""
    term, effect = acting.terms[number], acting.effects[number]
    known = term.sigmas(effect, acting.covariances()[number])
    for name, spread in spreads(regression, term, acting.values[number]).items():
        known[name] = spread if name == "times" else spread[0]
    return tuple(
        Parameter(spec.name, getattr(effect, spec.name), known.get(spec.name, 0.0), spec.unit)
        for spec in effect.parameters
        if spec.name != "intervals"
    )


def ordered(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """Return findings in order: without doubt, asserted, possible; most of the mismatch first in each."""
    return tuple(
        sorted(
            findings,
            key=lambda one: (one.probability <= EVEN, one.probability < ASSERTED, -one.explained),
        )
    )
