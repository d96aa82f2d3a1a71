"""What a report draws: the floor plan, residuals along the drive, and signatures."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING

import numpy as np

from mismatch.report.svg import Frame, band, dot, line, padded, picture, square, upright, whisker

if TYPE_CHECKING:
    from mismatch.diagnosis import Diagnosis, Signature, Trace
    from vehicle.se2 import Array

LEVELS = 6  # of colour, from within the noise to far outside it
FULL = 4.0  # sigma from which the colour is the strongest
_POINTS = 360  # of a residual trace: as many as a page has room for


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
    frame = square(420.0, trace.path[:, 0].tolist(), trace.path[:, 1].tolist())
    level = _levels(residual)
    parts = []
    for shade in range(LEVELS):
        for start, end in _runs(level == shade):
            points = trace.path[start : end + 2]
            if len(points) > 1:
                parts.append(line(frame, [(float(x), float(y)) for x, y in points], f"path c{shade}"))
    parts += [dot(frame, x, y, "event", 4.0) for x, y in places]
    return picture(frame, parts, "x [m]", "y [m]", "path of truck a, coloured by the mismatch")


def _levels(residual: Array) -> Array:
    """Return the shade (K,) of each window: its smoothed residual in sigma."""
    power = np.nan_to_num(residual**2, nan=0.0).sum(axis=1)
    count = np.maximum(np.isfinite(residual).sum(axis=1), 1)
    width = 9
    kernel = np.ones(width)
    mean = np.convolve(power, kernel, "same") / np.convolve(count, kernel, "same")
    excess = np.sqrt(np.maximum(mean - 1.0, 0.0))
    return np.asarray(np.minimum((excess / FULL * LEVELS).astype(int), LEVELS - 1))


def _runs(inside: Array) -> list[tuple[int, int]]:
    """Return the first and last numbers of stretches of true values."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], inside.astype(int), [0]))))
    return [(int(start), int(end) - 1) for start, end in zip(edges[::2], edges[1::2], strict=True)]


def residual_traces(diagnosis: Diagnosis) -> str:
    """Return the residual of every channel along each recording, before and after."""
    blocks = []
    for trace in diagnosis.evidence.traces:
        start = float(trace.time[0])
        shaded = [
            (first - start, last - start)
            for finding in diagnosis.findings
            for first, last in finding.where.intervals
            if first >= start and last <= float(trace.time[-1])
        ]
        for number, channel in enumerate(diagnosis.evidence.channels):
            known = np.isfinite(trace.before[:, number])
            if known.sum() < 2:
                continue
            laps = np.flatnonzero(np.diff(trace.lap) > 0)
            figure = _trace(
                trace.time[known] - start,
                trace.before[known, number],
                trace.after[known, number],
                shaded,
                [float(trace.time[at] - start) for at in laps],
                channel,
            )
            blocks.append(f"<figure>{figure}<figcaption>{escape(channel)}</figcaption></figure>")
    return f"<div class=grid2>{''.join(blocks)}</div>"


def _trace(
    time: Array,
    before: Array,
    after: Array,
    shaded: list[tuple[float, float]],
    laps: list[float],
    channel: str,
) -> str:
    high = max(3.5, float(np.abs(before).max()) * 1.05)
    frame = Frame(560.0, 190.0, (float(time[0]), float(time[-1])), (-high, high))
    parts = [band(frame, *interval) for interval in shaded] + [upright(frame, at) for at in laps]
    for rows, kind in ((before, "before"), (after, "after")):
        parts.append(line(frame, _envelope(time, rows), kind))
    return picture(frame, parts, "time [s]", "residual [sigma]", f"residual of {channel}, before and after")


def _envelope(time: Array, rows: Array) -> list[tuple[float, float]]:
    """Return a trace's least and greatest values in as many stretches as there is room for."""
    if len(rows) <= _POINTS:
        return [(float(x), float(y)) for x, y in zip(time, rows, strict=True)]
    points = []
    for part in np.array_split(np.arange(len(rows)), _POINTS // 2):
        ends = sorted({int(part[np.argmin(rows[part])]), int(part[np.argmax(rows[part])])})
        points += [(float(time[at]), float(rows[at])) for at in ends]
    return points


def signature(one: Signature) -> str:
    """Return a signature found, with its standard errors, and the one predicted."""
    heights = [
        *(one.found - one.sigma).tolist(),
        *(one.found + one.sigma).tolist(),
        *one.predicted.tolist(),
        0.0,
    ]
    frame = Frame(520.0, 240.0, padded(one.at.tolist()), padded(heights))
    predicted = [(float(x), float(y)) for x, y in zip(one.at, one.predicted, strict=True)]
    parts = [line(frame, predicted, "predicted")]
    for x, y, sigma in zip(one.at.tolist(), one.found.tolist(), one.sigma.tolist(), strict=True):
        parts += [whisker(frame, x, y, sigma), dot(frame, x, y, "foundpoint")]
    title = f"{one.channel} against {one.quantity}: found and predicted"
    return picture(frame, parts, one.quantity, f"{one.channel} [sigma]", title)
