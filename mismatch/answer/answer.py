"""From a search to the diagnosis: what is found and what is a trace, the fit, and the verdict in words."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omnimate.mismatch.answer.averaged import averaged
from omnimate.mismatch.answer.decisions import beyond_noise, reported, with_likelier_rivals
from omnimate.mismatch.answer.drawn import evidence_of
from omnimate.mismatch.answer.findings import found, merged, ordered, parameters_of, without_name
from omnimate.mismatch.answer.omnibus import leftover
from omnimate.mismatch.answer.relevance import relevant
from omnimate.mismatch.answer.rerun import rerun
from omnimate.mismatch.answer.unseen import blind, unseen_in_words
from omnimate.mismatch.candidates.terms import UNKNOWN
from omnimate.mismatch.diagnosis import ASSERTED, Calibrated, Change, Diagnosis, Fit
from omnimate.mismatch.evidence.search import FULLY_JUDGED, ranked_candidates
from omnimate.mismatch.heldout import HELD, METRIC, held_out, size
from omnimate.mismatch.noise.levels import nominal_levels

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.mismatch.diagnosis import Finding, Key, Verdict
    from omnimate.mismatch.fit import Fitted
    from omnimate.mismatch.heldout import HeldOut
    from omnimate.mismatch.investigate import Investigation


def answer(investigation: Investigation) -> Diagnosis:
    """Return the diagnosis; only effects that are in it are in the fit and in the effects file."""
    fit, posterior = investigation.fit, investigation.posterior
    residuals = held_out(fit)
    summary = summary_of(fit, residuals)
    remaining = max(0.0, float(residuals.train @ residuals.train) - len(residuals.train))
    fall = float(residuals.before @ residuals.before - residuals.train @ residuals.train)
    square = max(fall, 1e-9) + remaining
    left = leftover(posterior, investigation.unknown, investigation.members)
    present = found(investigation, left, square, summary.heldout.after)
    nameless = without_name(left, present, square)
    if left.relevant:
        present, nameless = [*present, *nameless], []
    findings, traces = relevant(ordered(merged(present)), fit, residuals, summary)
    findings, traces = reported(with_likelier_rivals(findings), (*traces, *nameless))
    findings, traces = beyond_noise(fit.regression, summary, findings, traces)
    acting = averaged(fit)
    effects = (*fit.chosen.effects, *acting.effects)
    if not findings and summary.gain[0] <= summary.gain[1]:  # what was calibrated predicts nothing new better
        effects, summary = fit.mounted, summary.unchanged()
    unseen = [] if findings or traces else blind(posterior)
    verdict: Verdict = "mismatch" if findings else "insufficient" if unseen else "agreement"
    says, drives = _in_words(findings, traces, unseen, summary)
    if not investigation.complete:
        says += " The search ended for its budget of time: a larger one may change the answer."
    quantities = [quantity for finding in findings for quantity in finding.depends_on]
    quantities += [prediction.quantity for prediction in left.predictions]
    return Diagnosis(
        verdict,
        says,
        findings,
        summary,
        remaining / square if findings else 0.0,
        tuple(dict.fromkeys(quantities)),
        investigation.signals[0].recording.vehicle.name,
        tuple(signals.recording.source for signals in investigation.signals),
        drives,
        evidence_of(fit, residuals, findings, _candidates(investigation, findings)),
        tuple(effect for effect in effects if effect.name != UNKNOWN),
        tuple(
            Calibrated(effect.name, effect.component, parameters_of(fit.regression, acting, number))
            for number, effect in enumerate(acting.effects)
        ),
        traces,
        investigation.complete,
    )


def _in_words(
    findings: Sequence[Finding], traces: Sequence[Finding], unseen: Sequence[Key], fit: Fit
) -> tuple[str, tuple[str, ...]]:
    """Return the verdict in a sentence, and drives that would say more."""
    if unseen:
        return unseen_in_words(unseen)
    if not findings:
        says = "Simulation and recording agree: nothing is left beyond the noise of sensors and floor."
        if traces:
            says = f"Simulation and recording agree, but for traces that change it little: {traces[0].says}"
        return says, ()
    first = findings[0]
    maybe = "" if first.probability >= ASSERTED else "Perhaps: "
    further = f", and {len(findings) - 1} more" if len(findings) > 1 else ""
    says = (
        f"{maybe}{first.says.rstrip('.')}{further}. Residual on data that no fit has seen: "
        f"{fit.heldout.before:.2f} before, {fit.heldout.after:.2f} after (1.00 is the expected noise)."
    )
    return says, tuple(dict.fromkeys(finding.separates for finding in findings if finding.separates))


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
        gains[key] = max(gains.get(key, 0.0), conditional.approximate_log_odds[candidate])
    order = sorted(gains, key=lambda key: (-probable.get(key, 0.0), -gains[key]))[:FULLY_JUDGED]
    return tuple((*key, gains[key], probable.get(key, 0.0)) for key in order)


def summary_of(fit: Fitted, residuals: HeldOut) -> Fit:
    """Return the residuals of a fit, without and with its effects."""
    regression = fit.regression
    channels = {}
    for number, name in enumerate(regression.windows[0].names):
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
        rerun(fit, residuals),
        regression.noise.named(),
        nominal_levels(regression.windows).named(),
    )
