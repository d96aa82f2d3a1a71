"""The rows of C 6.1 and C 6.2, each over several robots and floors."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from studies.papers.budget import explained
from studies.papers.drives import rectangle, straight
from studies.papers.estimates import CLAPPER_SONAR, ESTIMATORS, Estimator, return_errors, sizes
from studies.papers.rows import Row, at_least, at_most, drawn

if TYPE_CHECKING:
    from collections.abc import Callable

    from omnimate.vehicle.se2 import Array
    from studies.papers.robots import Term

    Errors = dict[Estimator, Array]

BUDGETED: tuple[Estimator, ...] = ("plain", "CLAPPER", "OmniMate")


def straight_line(count: int) -> tuple[Row, ...]:
    """Return the rows of C 6.1 over `count` robots."""
    rows: list[Row] = []
    for bumps in (0, 10):
        robots = [straight_errors(seed, bumps) for seed in range(count)]
        which = f"{2 * bumps} bumps" if bumps else "no bumps"
        for name in ESTIMATORS:
            what = f"worst heading of 3 runs, {name}, {which} [deg]"
            values = np.array([_worst_heading(errors, name) for errors in robots])
            bound = 1.0 if name == "CLAPPER" else None

            def figure(term: Term, bumps: int = bumps) -> Array:
                return np.array(
                    [_worst_heading(straight_errors(seed, bumps, term), "CLAPPER") for seed in range(count)]
                )

            rows.append(bounded("C", "6.1", what, values, bound, 2, figure))
        if bumps:
            turned = np.array([abs(np.degrees(errors["plain"][:, 2].mean())) for errors in robots])
            near = 5.0 < turned.mean() < 7.0
            what = "mean heading, plain, 10 bumps under each truck [deg]"
            rows.append(drawn("C", "6.1", what, "6.0", turned, "agrees" if near else "differs", 2))
    return tuple(rows)


def rectangular_path(count: int) -> tuple[Row, ...]:
    """Return the rows of C 6.2 over `count` robots: 10 + 10 runs with bumps, 5 + 5 without."""
    rows: list[Row] = []
    for bumps in (0, 10):
        which = f"{bumps} bumps" if bumps else "no bumps"
        robots = [rectangle_errors(seed, bumps) for seed in range(count)]
        for name in ESTIMATORS:
            for words, figure_of, bound, digits in (
                ("worst position, {} [mm]", _worst_position, 50.0, 0),
                ("mean |heading|, {} [deg]", _mean_heading, 0.3, 2),
            ):
                values = np.array([figure_of(errors, name) for errors in robots])
                wanted = bound if bumps and name == "CLAPPER" else None
                what = words.format(f"{name}, {which}")
                rows.append(
                    bounded("C", "6.2", what, values, wanted, digits, _figure(figure_of, count, bumps))
                )
    figure = _figure(_gain, count, 10)
    what = "mean |heading| without / with IPEC, bumps"
    return (*rows, explained(at_least("C", "6.2", what, 20.0, figure("nothing")), figure, 1))


def _figure(
    figure_of: Callable[[Errors, Estimator], float], count: int, bumps: int
) -> Callable[[Term], Array]:
    """Return what gives a figure of C 6.2 of each robot without a term `(count,)`."""
    return lambda term: np.array(
        [figure_of(rectangle_errors(seed, bumps, term), "CLAPPER") for seed in range(count)]
    )


def _worst_heading(errors: Errors, name: Estimator) -> float:
    return float(sizes(errors[name])[1].max())


def _worst_position(errors: Errors, name: Estimator) -> float:
    return float(sizes(errors[name])[0].max())


def _mean_heading(errors: Errors, name: Estimator) -> float:
    return float(sizes(errors[name])[1].mean())


def _gain(errors: Errors, name: Estimator) -> float:
    return _mean_heading(errors, "plain") / _mean_heading(errors, name)


@cache
def straight_errors(seed: int, bumps: int, without: Term = "nothing") -> Errors:
    """Return the return errors `(3, 3)` of C 6.1 by estimator."""
    drive = straight(seed, bumps, without)
    return return_errors(drive, CLAPPER_SONAR, seed, estimators(without), without)


@cache
def rectangle_errors(seed: int, bumps: int, without: Term = "nothing") -> Errors:
    """Return the return errors of C 6.2 by estimator, cw then ccw: `(20, 3)`, without bumps `(10, 3)`."""
    runs = 10 if bumps else 5
    cw, ccw = (
        return_errors(
            rectangle(seed, way, runs, bumps, without),
            CLAPPER_SONAR,
            2 * seed + (way == "cw"),
            estimators(without),
            without,
        )
        for way in ("cw", "ccw")
    )
    return {name: np.concatenate([cw[name], ccw[name]]) for name in cw}


def estimators(without: Term) -> tuple[Estimator, ...]:
    """Return the estimators that run: for the budget, those of the papers alone."""
    return ESTIMATORS if without == "nothing" else BUDGETED


def bounded(
    paper: str,
    place: str,
    what: str,
    values: Array,
    bound: float | None,
    digits: int,
    figure: Callable[[Term], Array],
) -> Row:
    """Return the row of values `(n,)` that must lie below a bound, if any, with its error budget."""
    if bound is None:
        return drawn(paper, place, what, "-", values, "shown", digits)
    return explained(at_most(paper, place, what, bound, values, digits), figure, digits)
