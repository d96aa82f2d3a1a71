"""From a search to the answer: findings, with the probabilities of all their rivals, and what is left."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from omnimate.effects import EFFECTS
from omnimate.effects.block import LINKAGE
from omnimate.effects.words import component_in_words
from omnimate.mismatch.answer.averaged import averaged
from omnimate.mismatch.answer.constancy import changing_error
from omnimate.mismatch.answer.doubts import EVEN, MISFIT, SUREST, surest_names, surest_unknown
from omnimate.mismatch.answer.drawn import evidence_of
from omnimate.mismatch.answer.omnibus import leftover
from omnimate.mismatch.answer.relevance import relevant
from omnimate.mismatch.answer.repeats import repeats_of
from omnimate.mismatch.answer.rerun import STRETCH, rerun
from omnimate.mismatch.answer.rivals import POSSIBLE, rivalry
from omnimate.mismatch.answer.where import channels_of, crossings, laps_at, places_at, row_names
from omnimate.mismatch.candidates.pushes import PUSH_REGIME
from omnimate.mismatch.candidates.terms import UNKNOWN
from omnimate.mismatch.diagnosis import (
    ASSERTED,
    Alternative,
    Calibrated,
    Change,
    Diagnosis,
    Finding,
    Fit,
    Key,
    Parameter,
    Where,
)
from omnimate.mismatch.evidence.search import FULLY_JUDGED, ranked_candidates
from omnimate.mismatch.heldout import HELD, METRIC, held_out, nominal_of, size
from omnimate.mismatch.noise.levels import is_at_limit, nominal_levels
from omnimate.mismatch.scans.nonlinear import spreads

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from omnimate.effects.effect import Effect
    from omnimate.mismatch.answer.constancy import RollingError
    from omnimate.mismatch.answer.omnibus import Leftover
    from omnimate.mismatch.answer.rivals import Rivalry
    from omnimate.mismatch.candidates.regression import Regression
    from omnimate.mismatch.diagnosis import Repeats, Verdict
    from omnimate.mismatch.evidence.posterior import Posterior
    from omnimate.mismatch.fit import Acting, Fitted
    from omnimate.mismatch.heldout import HeldOut
    from omnimate.mismatch.investigate import Investigation

_SHOWN = 6  # alternatives of a finding
# What a drive must be able to show before "agreement" means something: coefficients with a standard
# deviation of less than this share of what robots in use are off by.
_SEEN = 0.7
_DRIVES = {kind.name: kind.separating_drive for kind in EFFECTS if kind.separating_drive}


def answer(investigation: Investigation) -> Diagnosis:
    """Return the diagnosis; only effects that are in it are in the fit and in the effects file."""
    fit = investigation.fit
    nominal = nominal_of(fit)
    residuals = held_out(nominal, fit)
    remaining = max(0.0, float(residuals.train @ residuals.train) - len(residuals.train))
    fall = float(residuals.before @ residuals.before - residuals.train @ residuals.train)
    excess = max(fall, 1e-9) + remaining
    numbers = {member: number for number, member in enumerate(investigation.named)}
    posterior, members = investigation.posterior, investigation.members
    left = leftover(posterior, investigation.unknown, members)
    rows, chosen = fit.rows, fit.chosen
    parts = [rows[:, place] @ sizes for place, sizes in zip(chosen.places, chosen.values, strict=True)]
    explained = [float(part @ (part + 2.0 * rows[:, 0])) / excess for part in parts]
    surest = surest_names(investigation, parts, rows[:, 0], explained, left, size(residuals.after))
    surest_nameless = surest_unknown(investigation)
    repeats = repeats_of(fit, len(investigation.named))
    present = [
        _finding(
            fit, number, rivalry(investigation, member), explained[number], surest[number], repeats[number]
        )
        if (number := numbers.get(member)) is not None
        else _unknown(investigation, member, rivalry(investigation, member), excess, surest_nameless)
        for member in members
    ]
    summary = _fit(fit, residuals)
    nameless = _without_name(left, present, excess)
    if left.relevant:
        present += nameless
    findings, traces = relevant(_ordered(_merged(present)), fit, nominal, residuals, summary)
    traces = traces if left.relevant else (*traces, *nameless)
    findings, traces = _possible(_with_likelier_rivals(findings), traces)
    findings, traces = _beyond_noise(fit.regression, summary, findings, traces)
    acting = averaged(fit)
    effects = (*fit.chosen.effects, *acting.effects)
    if not findings and summary.gain[0] <= summary.gain[1]:  # what was calibrated predicts nothing new better
        effects, summary = fit.mounted, summary.unchanged()
    calibrated = tuple(
        Calibrated(effect.name, effect.component, _parameters(fit.regression, acting, number))
        for number, effect in enumerate(acting.effects)
    )
    drawn = evidence_of(fit, nominal, residuals, findings, _candidates(investigation, findings))
    unseen = [] if findings or traces else blind(posterior)
    verdict: Verdict = "mismatch" if findings else "insufficient" if unseen else "agreement"
    drives = tuple(dict.fromkeys(finding.separates for finding in findings if finding.separates))
    if findings:
        says = _headline(findings, summary)
    elif unseen:
        says, drives = unseen_in_words(unseen)
    else:
        says = "Simulation and recording agree: nothing is left beyond the noise of sensors and floor."
        if traces:
            says = f"Simulation and recording agree, but for traces that change it little: {traces[0].says}"
    if not investigation.complete:
        says += " The search ended for its budget of time: a larger one may change the answer."
    quantities = [quantity for finding in findings for quantity in finding.depends_on]
    quantities += [prediction.quantity for prediction in left.predictions]
    return Diagnosis(
        verdict,
        says,
        findings,
        summary,
        remaining / excess if findings else 0.0,
        tuple(dict.fromkeys(quantities)),
        investigation.signals[0].recording.vehicle.name,
        tuple(signals.recording.source for signals in investigation.signals),
        drives,
        drawn,
        tuple(effect for effect in effects if effect.name != UNKNOWN),
        calibrated,
        traces,
        investigation.complete,
    )


def _without_name(left: Leftover, present: Sequence[Finding], excess: float) -> list[Finding]:
    """Return what is left and can be predicted, unless an error without a name was already found.

    Pushes at single moments are none: they do not last, and are often what an error that lasts looks like.
    """
    strongest = left.strongest
    lasting = (finding for finding in present if finding.where.regime != PUSH_REGIME)
    if strongest is None or any(finding.effect == UNKNOWN for finding in lasting):
        return []
    shown = strongest.shown
    missed = f"missed after {STRETCH:.0f} s of open loop" if shown.open_loop else "left"
    named = excess if present else 0.0
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


def _with_likelier_rivals(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """Return findings, with an error without a name in the place of each that it is likelier than.

    Where no law of it is known, the effects of the fit still stand for it in a simulation.
    """
    regimes = {finding.component: finding.where.regime for finding in findings if finding.effect == UNKNOWN}
    answered = []
    for finding in findings:
        rival = next(iter(finding.alternatives), None)
        if (
            rival is None
            or rival.effect != UNKNOWN
            or rival.probability < ASSERTED
            or rival.probability <= finding.probability
        ):
            answered.append(finding)
            continue
        name = "an error" if finding.effect == UNKNOWN else finding.effect.replace("_", " ")
        answered.append(
            Finding(
                UNKNOWN,
                rival.component,
                min(rival.probability, SUREST),
                (Alternative(*finding.key, finding.probability),) if finding.probability >= POSSIBLE else (),
                replace(finding.where, regime=regimes.get(rival.component, "")),
                explained=finding.explained,
                says="Something that no effect of the library explains acts on "
                f"{component_in_words(rival.component)}, which is likelier than {name} of "
                f"{component_in_words(finding.component)}.",
            )
        )
    return _ordered(_merged(answered))


def _possible(
    findings: Sequence[Finding], traces: Sequence[Finding]
) -> tuple[tuple[Finding, ...], tuple[Finding, ...]]:
    """Return findings that are possible, themselves or a rival of theirs, and the others with the traces."""

    def is_possible(finding: Finding) -> bool:
        return finding.probability + sum(rival.probability for rival in finding.alternatives) >= POSSIBLE

    others = (finding for finding in findings if not is_possible(finding))
    return tuple(filter(is_possible, findings)), (*others, *traces)


def _beyond_noise(
    regression: Regression, fit: Fit, findings: tuple[Finding, ...], traces: tuple[Finding, ...]
) -> tuple[tuple[Finding, ...], tuple[Finding, ...]]:
    """Return findings and traces, with a finding where more than noise is missed and nothing is asserted.

    That is an encoder of the linkage whose noise level is as large as `MAX_ABOVE` allows: what is worse is
    faulty. Where nothing is found and all channels are missed by more, traces are findings, as no pose may
    predict the only one that shows an effect; without any, it is the worst channel.
    """
    if any(finding.probability >= ASSERTED for finding in findings):
        return findings, traces
    missed = {name: change.after for name, change in fit.channels.items()}
    nominal = nominal_levels(regression.windows)
    faulty = [name for name in LINKAGE if name in missed and is_at_limit(regression.noise, nominal, name)]
    worst = max(faulty, key=lambda name: missed[name], default="")
    if missed.get(worst, 0.0) >= MISFIT:
        return (_missed(worst, missed[worst], "largest noise that such an encoder has"), *findings), traces
    if findings or fit.heldout.after < MISFIT:
        return findings, traces
    findings, traces = _possible(_with_likelier_rivals(traces), ())
    if findings:
        return findings, traces
    worst = max(missed, key=lambda name: missed[name])
    return (_missed(worst, missed[worst], "noise that is expected"),), traces


def _missed(channel: str, factor: float, noise: str) -> Finding:
    """Return what is missed on a channel by a factor on some noise as a finding without a name."""
    component = channel.partition(".")[0]  # the truck of a pose
    says = (
        f"Something that no effect of the library explains acts on {component_in_words(component)}: where no "
        f"fit has seen it, {channel} is missed by {factor:.1f} times the {noise}."
    )
    return Finding(UNKNOWN, component, EVEN, where=Where((channel,), (), ""), explained=1.0, says=says)


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
        return _changing(effect, error, probability, explained, channels_of(regression, part_of))
    signals = [windows.signals for windows in regression.windows]
    intervals = crossings(effect, signals)
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
        Where(
            channels_of(regression, part_of),
            intervals,
            regime,
            laps_at(intervals, signals),
            places_at(intervals, signals),
        ),
        () if unknown else _parameters(fit.regression, fit.chosen, number),
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
    effect: Effect, error: RollingError, probability: float, explained: float, channels: tuple[str, ...]
) -> Finding:
    """Return a wheel's number that is not constant as a finding without a name."""
    return Finding(
        UNKNOWN,
        effect.component,
        min(probability, SUREST),
        (Alternative(effect.name, effect.component, min(1.0 - probability, EVEN)),),
        Where(channels, (), "time"),
        explained=min(1.0, max(0.0, explained)),
        says="Something that no effect of the library explains acts on "
        f"{component_in_words(effect.component)}: it rolls {error.begin:+.3%} more per turn than "
        f"vehicle.toml says at the beginning, and {error.end:+.3%} at the end.",
        depends_on=("time",),
    )


def _unknown(
    investigation: Investigation, member: int, rivals: Rivalry, excess: float, surest: float
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
        Where(channels_of(posterior.regression, part_of), (), quantity),
        (),
        min(1.0, float(part_of @ part_of) / excess),
        says,
        (quantity,),
        "",
    )


def _merged(findings: Sequence[Finding]) -> list[Finding]:
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


def _parameters(regression: Regression, acting: Acting, number: int) -> tuple[Parameter, ...]:
    term, effect = acting.terms[number], acting.effects[number]
    known = term.sigmas(effect, acting.covariances()[number])
    for name, spread in spreads(regression, term, acting.values[number]).items():
        known[name] = spread if name == "times" else spread[0]
    return tuple(
        Parameter(spec.name, getattr(effect, spec.name), known.get(spec.name, 0.0), spec.unit)
        for spec in effect.parameters
        if spec.name != "intervals"
    )


def _ordered(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """Return findings in order: without doubt, asserted, possible; most of the mismatch first in each."""
    return tuple(
        sorted(
            findings,
            key=lambda one: (one.probability <= EVEN, one.probability < ASSERTED, -one.explained),
        )
    )


def _candidates(
    investigation: Investigation, findings: Sequence[Finding]
) -> tuple[tuple[str, str, float, float], ...]:
    """Return the likeliest candidates: what each gains alone, and its probability."""
    probable = {finding.key: finding.probability for finding in findings}
    for finding in findings:
        for other in finding.alternatives:
            key = other.effect, other.component
            probable[key] = max(probable.get(key, 0.0), other.probability)
    posterior = investigation.posterior
    conditional = posterior.given(())
    gains: dict[Key, float] = {}
    ranked = ranked_candidates(posterior, conditional)[:FULLY_JUDGED]
    for candidate in (*ranked, *investigation.members):
        key = posterior.terms[candidate].key
        gains[key] = max(gains.get(key, 0.0), conditional.approximate_log_odds(candidate))
    order = sorted(gains, key=lambda key: (-probable.get(key, 0.0), -gains[key]))[:FULLY_JUDGED]
    return tuple((*key, gains[key], probable.get(key, 0.0)) for key in order)


def _fit(fit: Fitted, residuals: HeldOut) -> Fit:
    regression = fit.regression
    channels = {}
    for number, name in enumerate(row_names(regression.windows[0])):
        rows = regression.channel == number
        if rows.any():
            channels[name] = Change(size(residuals.before[rows]), size(residuals.after[rows]))
    gain = residuals.gain
    spread = float(gain.std(ddof=1) * np.sqrt(len(gain))) if len(gain) > 1 else 0.0
    return Fit(
        METRIC.format(HELD[residuals.kind]),
        Change(size(residuals.before), size(residuals.train)),
        Change(size(residuals.before), size(residuals.after)),
        channels,
        (float(gain.sum()), spread),
        rerun(regression, residuals, fit.mounted),
        regression.noise.named(),
        nominal_levels(regression.windows).named(),
    )


def _headline(findings: Sequence[Finding], fit: Fit) -> str:
    first = findings[0]
    maybe = "" if first.probability >= ASSERTED else "Perhaps: "
    further = f", and {len(findings) - 1} more" if len(findings) > 1 else ""
    return (
        f"{maybe}{first.says.rstrip('.')}{further}. Residual on data that no fit has seen: "
        f"{fit.heldout.before:.2f} before, {fit.heldout.after:.2f} after (1.00 is the expected noise)."
    )


def unseen_in_words(unseen: Sequence[Key]) -> tuple[str, tuple[str, ...]]:
    """Return a sentence on what a drive cannot show, and the drives that would."""
    drives = drives_for(sorted({effect for effect, _ in unseen}))
    what = ", ".join(
        f"the {effect.replace('_', ' ')} of {component_in_words(component)}"
        for effect, component in unseen[:4]
    )
    return f"Nothing stands out, but this drive cannot show {what}. Drive: {'; '.join(drives)}.", drives


def drives_for(effects: Iterable[str]) -> tuple[str, ...]:
    """Return one drive for each effect, by name, that separates it from others."""
    return tuple(dict.fromkeys(_DRIVES[effect] for effect in effects if effect in _DRIVES))


def blind(posterior: Posterior) -> list[Key]:
    """Return which of an owner's numbers this drive would not show to be wrong, were they."""
    needed = [number for number, term in enumerate(posterior.terms) if term.is_calibrated]
    gram, _ = posterior.given(()).gram_and_score([posterior.places[number].start for number in needed])
    spreads = 1.0 / np.sqrt(np.diagonal(gram) + 1.0)
    return [
        posterior.terms[number].key for number, spread in zip(needed, spreads, strict=True) if spread > _SEEN
    ]
