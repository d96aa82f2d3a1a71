"""What is reported of what was found: likelier rivals take its place, what is hardly possible is a trace."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from omnimate.effects.block import LINKAGE
from omnimate.effects.words import component_in_words
from omnimate.mismatch.answer.doubts import EVEN, MISFIT, SUREST
from omnimate.mismatch.answer.findings import merged, ordered
from omnimate.mismatch.answer.omnibus import RELEVANT
from omnimate.mismatch.answer.rivals import POSSIBLE
from omnimate.mismatch.candidates.terms import UNKNOWN
from omnimate.mismatch.diagnosis import ASSERTED, Alternative, Finding, Where
from omnimate.mismatch.noise.levels import is_at_limit, nominal_levels

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.mismatch.candidates.regression import Regression
    from omnimate.mismatch.diagnosis import Fit


def with_likelier_rivals(findings: Sequence[Finding]) -> tuple[Finding, ...]:
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
    return ordered(merged(answered))


def reported(
    findings: Sequence[Finding], traces: Sequence[Finding]
) -> tuple[tuple[Finding, ...], tuple[Finding, ...]]:
    """Return findings that are possible, themselves or a rival of theirs, and the others with the traces.

    Next to a name that is not doubted, what has none must be a twentieth of the mismatch: what is less may be
    what the name's law leaves.
    """
    has_name = any(finding.effect != UNKNOWN and finding.probability > EVEN for finding in findings)

    def is_reported(finding: Finding) -> bool:
        if has_name and finding.effect == UNKNOWN and finding.explained < RELEVANT:
            return False
        return finding.probability + sum(rival.probability for rival in finding.alternatives) >= POSSIBLE

    others = (finding for finding in findings if not is_reported(finding))
    return tuple(filter(is_reported, findings)), (*others, *traces)


def beyond_noise(
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
    findings, traces = reported(with_likelier_rivals(traces), ())
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
