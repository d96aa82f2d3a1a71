"""Figures inside a web page: SVG elements in the page's font, with the page's CSS variables as colours.

One figure serves a page in light and in dark: matplotlib draws each variable as a colour that nothing else
has, and the finished SVG names the variable in its place.
"""

from __future__ import annotations

import io
import re
from html import escape
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from omnimate.figures.style import STYLE

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SHADES = 6  # of the scale from within the noise to far outside it
VARIABLES = ("ink", "soft", "line", "before", "after", "band", *(f"c{shade}" for shade in range(SHADES)))
LEFT, BOTTOM, EDGE = 46.0, 30.0, 8.0  # space around the axes for tick labels and axis labels [px]
INCH = 72.0  # px of an SVG


def css(variable: str) -> str:
    """Return the colour that stands for a CSS variable of the page until the SVG is finished."""
    return f"#fe{VARIABLES.index(variable):04x}"


PAGE_STYLE: dict[Any, Any] = STYLE | {
    "svg.fonttype": "none",
    "font.size": 10,
    "xtick.labelsize": 9,
    "ytick.labelsize": 9,
    "xtick.major.size": 0,
    "ytick.major.size": 0,
    "axes.spines.left": False,
    "axes.spines.bottom": False,
    "axes.labelcolor": css("soft"),
    "xtick.labelcolor": css("soft"),
    "ytick.labelcolor": css("soft"),
    "grid.color": css("line"),
    "figure.facecolor": "none",
    "axes.facecolor": "none",
    "lines.solid_capstyle": "round",
}


_SIMPLIFIED: tuple[tuple[re.Pattern[str], Any], ...] = (
    (re.compile(r' id="[\w.]+_\d+"'), ""),  # names of groups, which are the same in all figures
    (re.compile(r" font-family: [^;]*;"), ""),  # the page's font
    (re.compile(r"(\.\d\d)\d+"), r"\1"),  # hundredths of a pixel
    (re.compile(r"#fe(00[0-9a-f]{2})"), lambda colour: f"var(--{VARIABLES[int(colour[1], 16)]})"),
)


def panel(width: float, height: float, x_label: str, y_label: str) -> Axes:
    """Return the axes of a new figure of one panel.

    Its size is in px.
    """
    with mpl.rc_context(PAGE_STYLE):
        figure = Figure(figsize=(width / INCH, height / INCH))
        inner = (width - LEFT - EDGE) / width, (height - BOTTOM - EDGE) / height
        axes = figure.add_axes((LEFT / width, BOTTOM / height, *inner))
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))
        axes.set_xlabel(x_label)
        axes.set_ylabel(y_label)
    return axes


def embedded(axes: Axes, title: str) -> str:
    """Return the figure of a panel as an `<svg>` element; the same content gives the same text.

    The title says what it shows, for people who cannot see it.
    """
    figure, buffer, name = axes.figure, io.StringIO(), escape(title)
    assert isinstance(figure, Figure), "a panel is the only one of its figure"
    with mpl.rc_context(PAGE_STYLE):
        figure.savefig(buffer, format="svg", metadata={"Date": None})
    content = buffer.getvalue().partition("</style>\n </defs>")[2]
    for pattern, replacement in _SIMPLIFIED:
        content = pattern.sub(replacement, content)
    width, height = INCH * figure.get_size_inches()
    return (
        f'<svg viewBox="0 0 {width:g} {height:g}" role="img" aria-label="{name}">'
        f"<title>{name}</title>{content.strip()}"
    )
