"""One row a printed number: what the paper says, what comes out here, and the verdict."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

if TYPE_CHECKING:
    from vehicle.se2 import Array

Verdict = Literal["agrees", "better", "print is wrong", "not explained", "not reached", "shown", "differs"]
_RESAMPLES = 1000


@dataclass(frozen=True, slots=True)
class Row:
    """A printed number beside ours.

    Attributes:
        paper: U, C or O; N for what was found since.
        place: in the paper.
        what: the number means, with its unit.
        printed: as it stands there.
        ours: with the 95 % interval of the mean where it is a Monte Carlo.
        verdict: differs is what nobody expects; not explained is a printed number that the paper's own
            scatter does not make; shown stands beside others for comparison.
    """

    paper: str
    place: str
    what: str
    printed: str
    ours: str
    verdict: Verdict


def number(paper: str, place: str, what: str, printed: float, ours: float, digits: int) -> Row:
    """Return the row of a number that must agree to half a unit of its last digit, and rounding in print."""
    agrees = abs(ours - printed) <= 0.55 * 10.0**-digits
    verdict: Verdict = "agrees" if agrees else "differs"
    shown = max(digits, 0)
    return Row(paper, place, what, f"{printed:.{shown}f}", f"{ours:.{shown}f}", verdict)


def at_most(paper: str, place: str, what: str, target: float, values: Array, digits: int = 1) -> Row:
    """Return the row of values `(n,)` whose mean must surely lie below a printed one."""
    verdict: Verdict = "agrees" if interval(values)[1] <= target else "not reached"
    return Row(paper, place, what, f"< {target:g}", spread(values, digits), verdict)


def at_least(paper: str, place: str, what: str, target: float, values: Array, digits: int = 1) -> Row:
    """Return the row of values `(n,)` whose mean must surely lie above a printed one."""
    verdict: Verdict = "agrees" if interval(values)[0] >= target else "not reached"
    return Row(paper, place, what, f"> {target:g}", spread(values, digits), verdict)


def interval(values: Array) -> tuple[float, float]:
    """Return the 95 % interval of the mean of values `(n,)`, by bootstrap."""
    again = np.random.default_rng(0).choice(values, (_RESAMPLES, len(values))).mean(axis=1)
    low, high = np.percentile(again, [2.5, 97.5]).tolist()
    return low, high


def spread(values: Array, digits: int = 1) -> str:
    """Return the mean of values `(n,)`, its 95 % interval, and the range of 5 to 95 % of them."""
    low, high = interval(values)
    first, last = np.percentile(values, [5.0, 95.0])
    mean = f"{values.mean():.{digits}f} ({low:.{digits}f} to {high:.{digits}f})"
    return f"{mean}, 5-95 % {first:.{digits}f} to {last:.{digits}f}"
