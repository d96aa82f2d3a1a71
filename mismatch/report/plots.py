"""The plots of a report: the floor plan, residuals along the drive, and signatures of findings."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING

import numpy as np

from omnimate.figures.page import BOTTOM, EDGE, LEFT, SHADES, css, embedded, panel

if TYPE_CHECKING:
    from omnimate.mismatch.diagnosis import Diagnosis, Signature, Trace
    from omnimate.vehicle.se2 import Array

FULL = 4.0  # standard deviations from which the colour is the strongest
_POINTS = 360  # of a residual trace, for which a page has room
_SMOOTHED = 9  # windows over which the mismatch on the floor plan is averaged
_PLAN, _TRACE, _SIGNATURE = 420.0, (560.0, 190.0), (520.0, 240.0)  # width, or width and height [px]
_NARROWEST = 1.5 / _TRACE[0]  # share of a trace's width that an interval needs to be seen


def floor_plans(diagnosis: Diagnosis) -> str:
    """Return the path of each recording, coloured by the mismatch, before and after."""
    blocks = []
    for trace in diagnosis.evidence.traces:
        places = [place for finding in diagnosis.findings for place in finding.where.places]
        before, after = _plan(trace, trace.before, places), _plan(trace, trace.after, [])
        blocks.append(
            f"<h3>{escape(trace.recording)}</h3><div class=pair>"
            f"<figure>{before}<figcaption>nominal robot</figcaption></figure>"
            f"<figure>{after}<figcaption>with what was found</figcaption></figure></div>"
        )
    return "".join(blocks)


def _plan(trace: Trace, residual: Array, places: list[tuple[float, float]]) -> str:
    axes = panel(_PLAN, _plan_height(trace.path), "x [m]", "y [m]")
    axes.set_aspect("equal", adjustable="datalim")
    level = _levels(residual)
    for shade in range(SHADES):
        axes.plot(*_steps(trace.path, level == shade), color=css(f"c{shade}"), linewidth=3.0)
    if places:
        x, y = np.array(places).T
        axes.scatter(x, y, s=50.0, facecolors="none", edgecolors=css("ink"), linewidths=1.6, zorder=3)
    return embedded(axes, "path of truck a, coloured by the mismatch")


def _plan_height(path: Array) -> float:
    """Return the height of a floor plan [px] at which a path `(K, 2)` fills it."""
    inner = _PLAN - LEFT - EDGE
    wide, tall = np.ptp(path, axis=0)
    return float(np.clip(inner * tall / wide if wide else inner, 0.35 * inner, 1.1 * inner)) + BOTTOM + EDGE


def _levels(residual: Array) -> Array:
    """Return the shade (K,) of each window: its smoothed residual in sigma."""
    power = np.nan_to_num(residual**2, nan=0.0).sum(axis=1)
    count = np.maximum(np.isfinite(residual).sum(axis=1), 1)
    kernel = np.ones(_SMOOTHED)
    mean = np.convolve(power, kernel, "same") / np.convolve(count, kernel, "same")
    excess = np.sqrt(np.maximum(mean - 1.0, 0.0))
    return np.asarray(np.minimum((excess / FULL * SHADES).astype(int), SHADES - 1))


def _steps(path: Array, drawn: Array) -> Array:
    """Return x and y `(2, M)` of some steps of a path `(K, 2)`, each followed by nan, which ends the line."""
    first = np.flatnonzero(drawn[:-1])
    steps = np.stack([path[first], path[first + 1], np.full((len(first), 2), np.nan)], axis=1)
    return steps.reshape(-1, 2).T


def residual_traces(diagnosis: Diagnosis) -> str:
    """Return the residual of every channel along each recording, before and after."""
    blocks = []
    for trace in diagnosis.evidence.traces:
        start, end = float(trace.time[0]), float(trace.time[-1])
        shaded = [
            (first - start, last - start)
            for finding in diagnosis.findings
            for first, last in finding.where.intervals
            if first >= start and last <= end
        ]
        for number, channel in enumerate(diagnosis.evidence.channels):
            if np.isfinite(trace.before[:, number]).sum() >= 2:
                figure = _trace(trace, number, shaded, channel)
                blocks.append(f"<figure>{figure}<figcaption>{escape(channel)}</figcaption></figure>")
    return f"<div class=grid2>{''.join(blocks)}</div>"


def _trace(trace: Trace, number: int, shaded: list[tuple[float, float]], channel: str) -> str:
    known = np.isfinite(trace.before[:, number])
    time, before, after = trace.time[known], trace.before[known, number], trace.after[known, number]
    time = time - trace.time[0]
    high = max(3.5, float(np.abs(before).max()) * 1.05)
    axes = panel(*_TRACE, "time [s]", "residual [sigma]")
    axes.set(xlim=(time[0], time[-1]), ylim=(-high, high))
    least = _NARROWEST * float(time[-1] - time[0])
    spans = [(first, max(last - first, least)) for first, last in shaded]
    axes.broken_barh(spans, (-high, 2.0 * high), facecolors=css("band"), linewidth=0)
    laps = trace.time[np.flatnonzero(np.diff(trace.lap) > 0)] - trace.time[0]
    axes.vlines(laps, -high, high, colors=css("soft"), linewidth=0.8, linestyles=(0, (4, 4)))
    for residual, kind in ((before, "before"), (after, "after")):
        axes.plot(*_envelope(time, residual), color=css(kind), linewidth=1.0)
    return embedded(axes, f"residual of {channel}, before and after")


def _envelope(time: Array, residual: Array) -> tuple[Array, Array]:
    """Return a trace's least and greatest values in as many stretches as there is room for."""
    if len(residual) <= _POINTS:
        return time, residual
    rows: list[int] = []
    for stretch in np.array_split(np.arange(len(residual)), _POINTS // 2):
        rows += sorted(
            {int(stretch[np.argmin(residual[stretch])]), int(stretch[np.argmax(residual[stretch])])}
        )
    return time[rows], residual[rows]


def signature(curve: Signature) -> str:
    """Return the plot of a signature: found, with standard errors, and predicted."""
    axes = panel(*_SIGNATURE, curve.quantity, f"{curve.channel} [sigma]")
    axes.axhline(0.0, color=css("line"), linewidth=1.2)
    axes.plot(curve.at, curve.predicted, color=css("after"), linewidth=2.0)
    axes.errorbar(
        curve.at, curve.measured, curve.sigma, fmt="o", color=css("before"), markersize=4.5, elinewidth=1.2
    )
    return embedded(axes, f"{curve.channel} against {curve.quantity}: found and predicted")
