"""The rows of O 3: its Table I, over several robots and floors."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from omnimate.calib.umbmark.extended import extended_umbmark
from studies.papers.budget import explained
from studies.papers.drives import laps
from studies.papers.estimates import ESTIMATORS, OMNIMATE_SONAR, Estimator, return_errors, sizes
from studies.papers.protocols import bounded, estimators
from studies.papers.rows import Row, at_least, drawn

if TYPE_CHECKING:
    from collections.abc import Callable

    from omnimate.vehicle.se2 import Array
    from studies.papers.drives import Turning
    from studies.papers.robots import Term

# O Table I: with and without IPEC; whether a position [mm] or a heading [degrees].
TABLE_I = (
    ("r_cg, no bumps [mm]", 25.0, 205.0),
    ("worst position, no bumps [mm]", 30.0, 275.0),
    ("mean |heading|, no bumps [deg]", 0.3, 3.7),
    ("worst |heading|, no bumps [deg]", 0.4, 5.3),
    ("worst position, bumps [mm]", 44.0, 465.0),
    ("mean |heading|, bumps [deg]", 0.8, 8.0),
    ("worst |heading|, bumps [deg]", 1.3, 11.3),
    ("|nonsyst. - mean syst.| [deg]", 1.2, 13.3),
)


def omnimate_laps(count: int) -> tuple[Row, ...]:
    """Return O 3 and its Table I over `count` robots: laps 1-10 with IPEC, 1-9 without."""
    rows: list[Row] = []
    for column, (what, with_ipec, without) in enumerate(TABLE_I):
        digits = 0 if "mm" in what else 2
        for name in ESTIMATORS:
            figure = _figure(name, column, count)
            if name == "plain":
                rows.append(_plain(what, without, figure("nothing"), digits))
                continue
            bound = with_ipec if name == "OmniMate" else None
            rows.append(bounded("O", "Table I", f"{what}, {name}", figure("nothing"), bound, digits, figure))
        gain = _gain(column, count)
        row = at_least("O", "Table I", f"{what}, without / with IPEC", 10.0, gain("nothing"))
        rows.append(explained(row, gain, 1))
    return tuple(rows)


def _plain(what: str, printed: float, values: Array, digits: int) -> Row:
    """Return the row of plain odometry, whose errors depend on wheels that the paper does not describe."""
    verdict = "agrees" if 0.5 < values.mean() / printed < 2.0 else "unexplained"
    return drawn("O", "Table I", f"{what}, plain", f"{printed:g}", values, verdict, digits)  # type: ignore[arg-type]  # one of the two


def _figure(name: Estimator, column: int, count: int) -> Callable[[Term], Array]:
    return lambda term: np.array([columns_of(seed, term)[name][column] for seed in range(count)])


def _gain(column: int, count: int) -> Callable[[Term], Array]:
    plain, ours = _figure("plain", column, count), _figure("OmniMate", column, count)
    return lambda term: plain(term) / ours(term)


@cache
def lap_errors_of(seed: int, way: Turning, without: Term = "nothing") -> dict[Estimator, Array]:
    """Return the return errors `(10, 3)` of O 3 by estimator."""
    return return_errors(
        laps(seed, way, without), OMNIMATE_SONAR, 2 * seed + (way == "cw"), estimators(without), without
    )


@cache
def columns_of(seed: int, without: Term = "nothing") -> dict[Estimator, Array]:
    """Return the columns `(8,)` of O Table I of one robot."""
    cw, ccw = lap_errors_of(seed, "cw", without), lap_errors_of(seed, "ccw", without)
    return {name: _table_i(cw[name], ccw[name], 9 if name == "plain" else 10) for name in cw}


def _table_i(cw: Array, ccw: Array, last: int) -> Array:
    """Return O Table I of the return errors `(10, 3)` of both directions: the worse one of each."""
    columns = []
    for errors in (cw, ccw):
        place, heading = sizes(errors[:last])
        centre = errors[:5, :2].mean(axis=0)
        smooth = [1e3 * np.hypot(*centre), place[:5].max(), heading[:5].mean(), heading[:5].max()]
        columns.append([*smooth, place[5:].max(), heading[5:].mean(), heading[5:].max()])
    extended = extended_umbmark(cw[:5, 2], ccw[:5, 2], cw[5:last, 2], ccw[5:last, 2])
    return np.append(np.max(columns, axis=0), np.degrees(extended.worst))
