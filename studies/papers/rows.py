"""One row a printed number: what the paper says, what comes out here, the verdict, and the error budget."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from omnimate.vehicle.se2 import Array
from studies.papers.robots import TERMS, Term

Verdict = Literal["agrees", "better", "misprint", "unexplained", "missed", "unsure", "shown", "differs"]
LEGEND = (
    "misprint: the print is wrong; missed: a printed bound that ours does not keep, and where the error comes"
    " from; unsure: too few robots to tell; unexplained: the paper's own scatter does not make it; shown: for"
    " comparison; agrees of plain laps: within a factor of two, as the paper tells no wheels' errors."
    " In brackets the 95 % interval of the mean. CLAPPER, OmniMate: the papers' equations; dead"
    " band: CLAPPER as `track` runs it. Everything is simulated."
)
_RESAMPLES = 1000


@dataclass(frozen=True, slots=True)
class Row:
    """A number of a paper, and the same number as measured here."""

    paper: str  # the paper, U, C or O; N for a number that no paper prints
    place: str  # place in the paper
    what: str  # meaning of the number, with its unit
    printed: str  # the number as printed
    ours: str  # the recomputed number, with the 95 % interval of the mean where it is a Monte Carlo
    # misprint is a wrong print; missed is a printed bound that is not kept; unsure is a printed bound within
    # the interval of ours; differs is an unexpected difference; unexplained is a printed number that the
    # scatter in the paper does not produce; shown is a number for comparison
    verdict: Verdict
    scatter: str = ""  # 5 to 95 % range of the single values where it is a Monte Carlo
    note: str = ""  # the reason, in one line


def number(paper: str, place: str, what: str, printed: float, ours: float, digits: int) -> Row:
    """Return the row of a number that must agree to half a unit of its last digit, and rounding in print."""
    agrees = abs(ours - printed) <= 0.55 * 10.0**-digits
    verdict: Verdict = "agrees" if agrees else "differs"
    shown = max(digits, 0)
    return Row(paper, place, what, f"{printed:.{shown}f}", f"{ours:.{shown}f}", verdict)


def judged(*, good: bool, verdict: Verdict = "agrees", otherwise: Verdict = "differs") -> Verdict:
    """Return one of two verdicts."""
    return verdict if good else otherwise


def at_most(paper: str, place: str, what: str, target: float, values: Array, digits: int) -> Row:
    """Return the row of values `(n,)` whose mean must surely lie below a printed one."""
    low, high = interval(values)
    verdict: Verdict = "agrees" if high <= target else "missed" if low > target else "unsure"
    return drawn(paper, place, what, f"< {target:g}", values, verdict, digits)


def at_least(paper: str, place: str, what: str, target: float, values: Array) -> Row:
    """Return the row of values `(n,)` whose mean must surely lie above a printed one."""
    low, high = interval(values)
    verdict: Verdict = "agrees" if low >= target else "missed" if high < target else "unsure"
    return drawn(paper, place, what, f"> {target:g}", values, verdict)


def interval(values: Array) -> tuple[float, float]:
    """Return the 95 % interval of the mean of values `(n,)`, by bootstrap."""
    again = np.random.default_rng(0).choice(values, (_RESAMPLES, len(values))).mean(axis=1)
    low, high = np.percentile(again, [2.5, 97.5]).tolist()
    return low, high


def drawn(
    paper: str, place: str, what: str, printed: str, values: Array, verdict: Verdict, digits: int = 1
) -> Row:
    """Return the row of values `(n,)` of a Monte Carlo: their mean, its interval, and their scatter."""
    low, high = interval(values)
    first, last = np.percentile(values, [5.0, 95.0])
    mean = f"{values.mean():.{digits}f} ({low:.{digits}f}..{high:.{digits}f})"
    return Row(paper, place, what, printed, mean, verdict, f"{first:.{digits}f}..{last:.{digits}f}")


_SHOWN = 3  # terms


def explained(row: Row, figure: Callable[[Term], Array], digits: int) -> Row:
    """Return the row, with its error budget as a note unless it surely keeps a printed bound.

    `figure` returns the row's values `(n,)` without a given cause.
    """
    if row.verdict not in {"missed", "unsure"}:
        return row
    whole = float(figure("nothing").mean())
    parts = {term: float(figure(term).mean()) for term in TERMS[1:]}
    largest = sorted(parts, key=lambda term: -abs(parts[term] - whole))[:_SHOWN]
    words = ", ".join(f"no {term} {parts[term]:.{digits}f}" for term in largest)
    return replace(row, note=f"{whole:.{digits}f}, switching one cause off: {words}")
