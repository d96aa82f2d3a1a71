"""The rows of C 6.1, C 6.2 and O 3, each over several robots and floors."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from calib.extended import extended_umbmark
from reproduction.drives import (
    CLAPPER_SONAR,
    ESTIMATORS,
    OMNIMATE_SONAR,
    Estimator,
    laps,
    rectangle,
    return_errors,
    sizes,
    straight,
)
from reproduction.rows import Row, Verdict, at_least, at_most, spread

if TYPE_CHECKING:
    from vehicle.se2 import Array

# O Table I: with and without IPEC; whether a position [mm] or a heading [degrees].
TABLE_I = (
    ("r_cg, no bumps [mm]", 25.0, 205.0),
    ("worst position, no bumps [mm]", 30.0, 275.0),
    ("mean |heading|, no bumps [degrees]", 0.3, 3.7),
    ("worst |heading|, no bumps [degrees]", 0.4, 5.3),
    ("worst position, bumps [mm]", 44.0, 465.0),
    ("mean |heading|, bumps [degrees]", 0.8, 8.0),
    ("worst |heading|, bumps [degrees]", 1.3, 11.3),
    ("|nonsystematic - mean systematic| [degrees]", 1.2, 13.3),
)


def straight_line(count: int) -> tuple[Row, ...]:
    """Return C 6.1 over `count` robots."""
    rows = []
    for bumps in (0, 10):
        several = [return_errors(straight(seed, bumps), CLAPPER_SONAR, seed) for seed in range(count)]
        which = f"{2 * bumps} bumps" if bumps else "no bumps"
        for name in ESTIMATORS:
            worst = np.array([sizes(one[name])[1].max() for one in several])
            what = f"worst heading of 3 runs, {name}, {which} [degrees]"
            rows.append(_beside("C", "6.1", what, worst, 1.0 if name == "CLAPPER" else None, 2))
        if bumps:
            turned = np.array([np.degrees(one["plain"][:, 2].mean()) for one in several])
            near = 5.0 < abs(turned.mean()) < 7.0
            what = "mean heading, plain, 10 bumps under each truck [degrees]"
            rows.append(
                Row("C", "6.1", what, "6.0", spread(np.abs(turned), 2), "agrees" if near else "differs")
            )
    return tuple(rows)


def rectangular_path(count: int) -> tuple[Row, ...]:
    """Return C 6.2 over `count` robots: 10 + 10 runs with bumps, 5 + 5 without."""
    rows: list[Row] = []
    for bumps, runs in ((0, 5), (10, 10)):
        several = [_both_ways(seed, bumps, runs) for seed in range(count)]
        which = f"{bumps} bumps" if bumps else "no bumps"
        for name in ESTIMATORS:
            place = np.array([sizes(one[name])[0].max() for one in several])
            heading = np.array([sizes(one[name])[1].mean() for one in several])
            ours = bumps > 0 and name == "CLAPPER"
            rows += [
                _beside("C", "6.2", f"worst position, {name}, {which} [mm]", place, 50.0 if ours else None),
                _beside(
                    "C",
                    "6.2",
                    f"mean |heading|, {name}, {which} [degrees]",
                    heading,
                    0.3 if ours else None,
                    2,
                ),
            ]
        if bumps:
            gain = np.array(
                [sizes(one["plain"])[0].mean() / sizes(one["CLAPPER"])[0].mean() for one in several]
            )
            rows.append(at_least("C", "6.2", "mean position without over with IPEC, bumps", 20.0, gain))
    return tuple(rows)


def _both_ways(seed: int, bumps: int, runs: int) -> dict[Estimator, Array]:
    cw, ccw = (
        return_errors(rectangle(seed, way, runs, bumps), CLAPPER_SONAR, 2 * seed + (way == "cw"))
        for way in ("cw", "ccw")
    )
    return {name: np.concatenate([cw[name], ccw[name]]) for name in ESTIMATORS}


def omnimate_laps(count: int) -> tuple[Row, ...]:
    """Return O 3 and its Table I over `count` robots: laps 1-10 with IPEC, 1-9 without."""
    several = [_columns(seed) for seed in range(count)]
    columns = {name: np.array([one[name] for one in several]) for name in ESTIMATORS}
    rows: list[Row] = []
    for column, (what, with_ipec, without) in enumerate(TABLE_I):
        for name in ESTIMATORS:
            values = columns[name][:, column]
            digits = 0 if "mm" in what else 2
            target = with_ipec if name == "OmniMate" else None
            rows.append(_beside("O", "Table I", f"{what}, {name}", values, target, digits))
            if name == "plain":
                near = 0.5 < values.mean() / without < 2.0
                verdict: Verdict = "agrees" if near else "not explained"
                rows[-1] = Row(
                    "O", "Table I", f"{what}, plain", f"{without:g}", spread(values, digits), verdict
                )
        gain = columns["plain"][:, column] / columns["OmniMate"][:, column]
        rows.append(at_least("O", "Table I", f"{what}, without over with IPEC", 10.0, gain))
    return tuple(rows)


def _columns(seed: int) -> dict[Estimator, Array]:
    """Return the columns `(8,)` of O Table I of one robot."""
    cw, ccw = (
        return_errors(laps(seed, way), OMNIMATE_SONAR, 2 * seed + (way == "cw")) for way in ("cw", "ccw")
    )
    return {name: _table_i(cw[name], ccw[name], 9 if name == "plain" else 10) for name in ESTIMATORS}


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


def _beside(paper: str, place: str, what: str, values: Array, target: float | None, digits: int = 0) -> Row:
    if target is not None:
        return at_most(paper, place, what, target, values, digits)
    return Row(paper, place, what, "-", spread(values, digits), "shown")
