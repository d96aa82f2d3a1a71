"""The HTML page of a diagnosis: the verdict, the findings, and the evidence for them."""

from __future__ import annotations

import math
from html import escape
from typing import TYPE_CHECKING

from omnimate.effects.words import component_in_words
from omnimate.figures.page import SHADES
from omnimate.mismatch.report.plots import FULL, floor_plans, residual_traces, signature
from omnimate.mismatch.report.style import Head, html_report

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from omnimate.mismatch.diagnosis import Change, Diagnosis, Finding, Fit, Parameter

_UNITS = {"m": (1e3, "mm"), "rad": (math.degrees(1.0), "degrees"), "1": (1.0, "")}
_EVENTS = 12  # shown one by one

HOW_TO_READ = (
    "The robot of vehicle.toml was driven in simulation by the wheel motion that was recorded, and what its "
    "sensors would have shown was held against what they did show. Residuals are in sigma, the sensors' and "
    "the floor's own noise, which is estimated from the recording itself: 1.00 is a perfect simulation. "
    "Probabilities compare every effect of the library, alone and together, and unknown ones; from 50 % on a "
    "finding is an assertion, below it a possibility. Held-out figures are of stretches that no parameter "
    "has seen."
)


def render(diagnosis: Diagnosis) -> str:
    """Return the report of a diagnosis as one HTML page, with nothing outside itself."""
    verdict, recordings = diagnosis.verdict, f"Recordings: {', '.join(diagnosis.recordings)}"
    head = Head("Diagnosis", diagnosis.robot or "robot", verdict, verdict, diagnosis.says, recordings)
    sections = [
        *_findings(diagnosis),
        *_traces(diagnosis),
        *_calibrated(diagnosis),
        *_proof(diagnosis),
        *_next(diagnosis),
    ]
    return html_report(head, sections, HOW_TO_READ)


def _findings(diagnosis: Diagnosis) -> Iterable[str]:
    if not diagnosis.findings:
        return
    yield "<h2>What was found</h2>"
    for number, finding in enumerate(diagnosis.findings):
        pictures = "".join(
            f"<figure>{signature(curve)}<figcaption>points: found; line: predicted</figcaption></figure>"
            for curve in diagnosis.evidence.signatures
            if curve.finding == number
        )
        yield f"<article class=card>{_finding(finding)}{pictures}</article>"


def _traces(diagnosis: Diagnosis) -> Iterable[str]:
    if not diagnosis.traces:
        return
    yield "<h2>Traces</h2>"
    yield "<p class=soft>Present, but they change what the simulation misses by less than a twentieth.</p>"
    yield from (f"<article class=card>{_finding(trace)}</article>" for trace in diagnosis.traces)


def _finding(finding: Finding) -> str:
    others = "".join(
        _bar(f"or {_name(other.effect)}, {component_in_words(other.component)}", other.probability)
        for other in finding.alternatives
    )
    likeliest = _bar(f"{_name(finding.effect)}, {component_in_words(finding.component)}", finding.probability)
    separates = f"<p>To tell them apart, drive: {escape(finding.separates)}.</p>" if finding.separates else ""
    depends = f"<p>Depends on: {escape(', '.join(finding.depends_on))}.</p>" if finding.depends_on else ""
    return (
        f"<h3>{escape(finding.says)}</h3>{likeliest}"
        f"{others}{_parameters(finding.parameters)}{_repeats(finding)}"
        f"<p class=soft>{_where(finding)}</p>{depends}{separates}"
    )


def _name(effect: str) -> str:
    return effect.replace("_", " ")


def _bar(label: str, probability: float) -> str:
    share = f"{100.0 * probability:.0f} %" if probability < 0.995 else "> 99 %"
    return (
        f"<div class=bar><span>{escape(label)}</span><i><b style='width:{100.0 * probability:.1f}%'></b></i>"
        f"<span>{share}</span></div>"
    )


def _where(finding: Finding) -> str:
    where = finding.where
    words = [f"explains {100.0 * finding.explained:.0f} % of the mismatch"]
    if where.regime:
        words.append(f"acts: {where.regime}")
    if where.channels:
        words.append(f"seen on {', '.join(where.channels)}")
    if where.laps:
        words.append(f"in lap {', '.join(str(lap) for lap in where.laps)}")
    if where.intervals:
        spans = ", ".join(f"{start:.2f} to {end:.2f} s" for start, end in where.intervals[:_EVENTS])
        words.append(f"at {spans}" + (" and more" if len(where.intervals) > _EVENTS else ""))
    return escape("; ".join(words) + ".")


def _calibrated(diagnosis: Diagnosis) -> Iterable[str]:
    if not diagnosis.calibrated:
        return
    yield "<h2>Calibrated as well</h2>"
    yield "<p class=soft>What poses identify in any case. No finding, but in the effects file.</p>"
    rows = "".join(
        _row(f"{_name(calibrated.effect)}, {component_in_words(calibrated.component)}", *row)
        for calibrated in diagnosis.calibrated
        for parameter in calibrated.parameters
        for row in _values(parameter)
    )
    yield _table("number<th>parameter<th>value<th>95 % interval<th>unit", rows)


def _parameters(parameters: Sequence[Parameter], value: str = "value") -> str:
    if not parameters:
        return ""
    rows = "".join(_row(*row) for parameter in parameters for row in _values(parameter))
    return _table(f"parameter<th>{value}<th>95 % interval<th>unit", rows)


def _repeats(finding: Finding) -> str:
    if finding.repeats is None:
        return ""
    same = "The recordings agree on it." if finding.repeats.agree else "The recordings differ in it."
    table = _parameters([finding.repeats.parameter], "by each recording alone")
    return f"<p>{same}</p>{table}"


def _table(head: str, rows: str) -> str:
    return f"<div class=scroll><table><tr><th>{head}</tr>{rows}</table></div>"


def _values(parameter: Parameter) -> list[tuple[str, str, str, str]]:
    factor, unit = _UNITS.get(parameter.unit, (1.0, parameter.unit))
    values = parameter.value if isinstance(parameter.value, tuple) else (parameter.value,)
    sigmas = parameter.sigma if isinstance(parameter.sigma, tuple) else (parameter.sigma,)
    rows = []
    for value, sigma in list(zip(values, sigmas, strict=True))[:_EVENTS]:
        digits, interval = 3, "fixed"
        if sigma > 0.0:
            half = 1.96 * sigma
            digits = max(0, min(6, 1 - math.floor(math.log10(1.96 * factor * sigma))))
            interval = f"{factor * (value - half):.{digits}f} to {factor * (value + half):.{digits}f}"
        rows.append((parameter.name, f"{factor * value:.{digits}f}", interval, unit))
    return rows


def _row(*cells: str) -> str:
    return "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in cells) + "</tr>"


def _proof(diagnosis: Diagnosis) -> Iterable[str]:
    if diagnosis.fit is None:
        return
    yield "<h2>Where it is</h2>"
    steps = "".join(f"<i style='background:var(--c{shade})'></i>" for shade in range(SHADES))
    yield f"<div class=key>within the noise {steps} {FULL:g} sigma and more; circles: events</div>"
    yield floor_plans(diagnosis)
    yield "<h2>How far the model of it goes</h2>"
    yield _fit(diagnosis.fit)
    yield "<h3>Residual along the drive: before (orange), after on stretches that no fit has seen (blue)</h3>"
    yield residual_traces(diagnosis)
    if diagnosis.evidence.candidates:
        yield "<h2>What was considered</h2><p class=soft>Probability of being part of the right answer.</p>"
        for effect, component, gain, probability in diagnosis.evidence.candidates:
            label = f"{_name(effect)}, {component_in_words(component)} (alone: log evidence {gain:+.1f})"
            yield _bar(label, probability)
    left = 100.0 * diagnosis.unexplained
    depends = f", and depends on {', '.join(diagnosis.depends_on)}" if diagnosis.depends_on else ""
    yield f"<p>{left:.0f} % of the mismatch is left unexplained{escape(depends)}.</p>"


def _fit(fit: Fit) -> str:
    channels = "".join(
        _row(name, f"{change.before:.2f}", f"{change.after:.2f}") for name, change in fit.channels.items()
    )
    total = _row("all, held out", f"{fit.heldout.before:.2f}", f"{fit.heldout.after:.2f}")
    seen = _row("all, as fitted", f"{fit.train.before:.2f}", f"{fit.train.after:.2f}")
    rerun = "".join(_row(*_open_loop(name, change)) for name, change in fit.rerun.items())
    noise = "".join(_row(name, f"{value:.3g}") for name, value in fit.noise.items())
    return (
        f"<p class=soft>{escape(fit.metric)}. "
        f"Gain in half the chi-square: {fit.gain[0]:.0f} +- {fit.gain[1]:.0f}.</p>"
        "<div class=grid2><div class=scroll><h3>Residual in sigma, 1.00 is perfect</h3>"
        f"<table><tr><th>channel<th>before<th>after</tr>{channels}{total}{seen}</table></div>"
        "<div class=scroll><h3>The simulator itself, run again from the effects</h3>"
        f"<table><tr><th>open loop<th>before<th>after<th>unit</tr>{rerun}</table>"
        f"<h3>Noise levels used</h3><table>{noise}</table></div></div>"
    )


def _open_loop(name: str, change: Change) -> tuple[str, str, str, str]:
    """Return a row of a channel's open-loop mismatch, in degrees or mm."""
    angle = "joint" in name or "heading" in name
    factor, unit = (math.degrees(1.0), "degrees") if angle else (1e3, "mm")
    return name, f"{factor * change.before:.2f}", f"{factor * change.after:.2f}", unit


def _next(diagnosis: Diagnosis) -> Iterable[str]:
    if diagnosis.drive_next:
        items = "".join(f"<li>{escape(drive)}</li>" for drive in diagnosis.drive_next)
        yield f"<h2>What to drive next</h2><ul>{items}</ul>"
