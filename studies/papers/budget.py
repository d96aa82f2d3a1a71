"""The budget of an error: each of its causes is switched off alone, with everything else unchanged."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from studies.papers.robots import TERMS

if TYPE_CHECKING:
    from collections.abc import Callable

    from omnimate.vehicle.se2 import Array
    from studies.papers.robots import Term
    from studies.papers.rows import Row

_SHOWN = 3  # terms


def explained(row: Row, figure: Callable[[Term], Array], digits: int) -> Row:
    """Return the row, with its error budget as a note unless it surely keeps a printed bound.

    Args:
        row: The row to explain.
        figure: Function that returns the row's values `(n,)` without a given cause.
        digits: Number of digits after the decimal point.
    """
    if row.verdict not in {"missed", "unsure"}:
        return row
    whole = float(figure("nothing").mean())
    parts = {term: float(figure(term).mean()) for term in TERMS[1:]}
    largest = sorted(parts, key=lambda term: -abs(parts[term] - whole))[:_SHOWN]
    words = ", ".join(f"no {term} {parts[term]:.{digits}f}" for term in largest)
    return replace(row, note=f"{whole:.{digits}f}, switching one cause off: {words}")
