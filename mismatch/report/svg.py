"""Small plots as inline SVG: a frame with axes, lines, bands and points, in the page's own colours."""

from __future__ import annotations

import math
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Frame:
    """A plot's area and scales.

    Attributes:
        width: of the picture [px].
        height: likewise.
        x: range of the horizontal axis.
        y: range of the vertical axis.
    """

    width: float
    height: float
    x: Point
    y: Point

    LEFT = 46.0
    BOTTOM = 30.0
    EDGE = 8.0

    def at(self, x: float, y: float) -> Point:
        """Return where a point is drawn [px]."""
        across = (x - self.x[0]) / ((self.x[1] - self.x[0]) or 1.0)
        up = (y - self.y[0]) / ((self.y[1] - self.y[0]) or 1.0)
        inner = self.height - self.BOTTOM - self.EDGE
        return (
            self.LEFT + across * (self.width - self.LEFT - self.EDGE),
            self.EDGE + (1.0 - up) * inner,
        )


def square(width: float, xs: Sequence[float], ys: Sequence[float]) -> Frame:
    """Return a frame in which a metre is as long on both axes."""
    x, y = padded(xs), padded(ys)
    inner = width - Frame.LEFT - Frame.EDGE
    tall = min(max(inner * (y[1] - y[0]) / (x[1] - x[0]), 0.35 * inner), 1.1 * inner)
    scale = max((x[1] - x[0]) / inner, (y[1] - y[0]) / tall)
    middle_x, middle_y = 0.5 * (x[0] + x[1]), 0.5 * (y[0] + y[1])
    half_x, half_y = 0.5 * inner * scale, 0.5 * tall * scale
    return Frame(
        width,
        tall + Frame.BOTTOM + Frame.EDGE,
        (middle_x - half_x, middle_x + half_x),
        (middle_y - half_y, middle_y + half_y),
    )


def padded(values: Sequence[float]) -> Point:
    """Return the range of values with a twentieth to either side."""
    low, high = min(values), max(values)
    pad = 0.05 * (high - low) or 0.5
    return low - pad, high + pad


def picture(frame: Frame, parts: Iterable[str], x_label: str, y_label: str, title: str) -> str:
    """Return a whole picture with its axes."""
    axes = "".join(_axes(frame, x_label, y_label))
    return (
        f'<svg viewBox="0 0 {frame.width:.0f} {frame.height:.0f}" role="img" aria-label="{escape(title)}">'
        f"<title>{escape(title)}</title>{axes}{''.join(parts)}</svg>"
    )


def _axes(frame: Frame, x_label: str, y_label: str) -> Iterable[str]:
    left, bottom = frame.at(frame.x[0], frame.y[0])
    right, top = frame.at(frame.x[1], frame.y[1])
    for tick in ticks(*frame.x):
        x, _ = frame.at(tick, frame.y[0])
        yield f'<line class="grid" x1="{x:.1f}" y1="{top:.1f}" x2="{x:.1f}" y2="{bottom:.1f}"/>'
        yield f'<text class="tick" x="{x:.1f}" y="{bottom + 11:.1f}" text-anchor="middle">{tick:g}</text>'
    for tick in ticks(*frame.y):
        _, y = frame.at(frame.x[0], tick)
        yield f'<line class="grid" x1="{left:.1f}" y1="{y:.1f}" x2="{right:.1f}" y2="{y:.1f}"/>'
        yield f'<text class="tick" x="{left - 4:.1f}" y="{y + 3:.1f}" text-anchor="end">{tick:g}</text>'
    middle = 0.5 * (left + right)
    down = frame.height - 3.0
    yield f'<text class="label" x="{middle:.1f}" y="{down:.1f}" text-anchor="middle">{escape(x_label)}</text>'
    half = 0.5 * (top + bottom)
    yield (
        f'<text class="label" x="10" y="{half:.1f}" text-anchor="middle" '
        f'transform="rotate(-90 10 {half:.1f})">{escape(y_label)}</text>'
    )


def ticks(low: float, high: float, count: int = 5) -> list[float]:
    """Return round numbers within a range."""
    if not high > low:
        return [low]
    rough = (high - low) / count
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(power * part for part in (1.0, 2.0, 5.0, 10.0) if power * part >= rough)
    first = math.ceil(low / step)
    return [round(number * step, 10) for number in range(first, math.floor(high / step) + 1)]


def line(frame: Frame, points: Sequence[Point], kind: str) -> str:
    """Return a polyline of a class."""
    drawn = " ".join(f"{x:.1f},{y:.1f}" for x, y in (frame.at(*point) for point in points))
    return f'<polyline class="{kind}" points="{drawn}"/>'


def band(frame: Frame, start: float, end: float) -> str:
    """Return a shaded stretch of the horizontal axis, never too narrow to be seen."""
    left, top = frame.at(start, frame.y[1])
    right, bottom = frame.at(end, frame.y[0])
    width = max(right - left, 1.5)
    return (
        f'<rect class="band" x="{left:.1f}" y="{top:.1f}" width="{width:.1f}" height="{bottom - top:.1f}"/>'
    )


def upright(frame: Frame, x: float) -> str:
    """Return a vertical line."""
    (left, top), (_, bottom) = frame.at(x, frame.y[1]), frame.at(x, frame.y[0])
    return f'<line class="lap" x1="{left:.1f}" y1="{top:.1f}" x2="{left:.1f}" y2="{bottom:.1f}"/>'


def dot(frame: Frame, x: float, y: float, kind: str, radius: float = 2.6) -> str:
    """Return a point."""
    across, down = frame.at(x, y)
    return f'<circle class="{kind}" cx="{across:.1f}" cy="{down:.1f}" r="{radius}"/>'


def whisker(frame: Frame, x: float, y: float, sigma: float) -> str:
    """Return a standard error about a point."""
    (across, low), (_, high) = frame.at(x, y - sigma), frame.at(x, y + sigma)
    return f'<line class="found" x1="{across:.1f}" y1="{low:.1f}" x2="{across:.1f}" y2="{high:.1f}"/>'
