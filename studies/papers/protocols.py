"""The rows of C 6.1, C 6.2 and O 3, each over several robots and floors."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache, partial
from typing import Literal, get_args

import numpy as np

from omnimate.calib.umbmark.extended import extended_umbmark
from omnimate.ipec.corrections import advance_all
from omnimate.ipec.corrector import Corrector, Method, correct
from omnimate.ipec.filter.estimate import estimate
from omnimate.ipec.filter.prior import Prior
from omnimate.ipec.filter.smoother import smooth
from omnimate.ipec.readings import ordered_counts
from omnimate.vehicle.recording import Poses, Recording
from omnimate.vehicle.se2 import Array
from studies.papers.linkage_numbers import lap_errors
from studies.papers.robots import LEFT_BEHIND, UNCALIBRATED, Term, Turning, laps, rectangle, straight
from studies.papers.rows import Row, at_least, at_most, drawn, explained, judged

# CLAPPER and OmniMate are the papers' equations to the letter, but for the signs. "dead band" is what this
# project runs: CLAPPER which leaves alone what lies within a step of the joint encoder.
Estimator = Literal["plain", "CLAPPER", "OmniMate", "dead band", "filter", "smoother"]
ESTIMATORS: tuple[Estimator, ...] = get_args(Estimator)
BUDGETED: tuple[Estimator, ...] = ("plain", "CLAPPER", "OmniMate")
Errors = dict[Estimator, Array]

# C 6: "to within +-2 millimeters", "about +-0.25 degrees"; O 3.2: +-3 mm beside, +-0.2 degrees. Bounds, not
# standard deviations: with 0.2 degrees of deviation, O's worst of ten laps would be 0.6 degrees and not 0.4.
# They are taken as half widths of a uniform distribution (GUM 4.3.7). O's rear sonar has +-30 mm, 0.3 % of
# 10 m: an error of scale, which the fixes before and after a lap at the same place share.
CLAPPER_SONAR = np.array([0.002, 0.002, math.radians(0.25)])
OMNIMATE_SONAR = np.array([0.003, 0.003, math.radians(0.2)])


def return_errors(recording: Recording, sonar: Array, seed: int, without: Term = "nothing") -> Errors:
    """Return the return errors `(L, 3)` of each estimator, measured with a sonar of half widths `(3,)`.

    Each estimate is compared lap by lap, from the fix before to the fix after it; no estimator is given more.
    For the error budget those of the papers alone run.
    """
    estimators = ESTIMATORS if without == "nothing" else BUDGETED
    seen = measured(recording, sonar if without != "sonar" else 1e-9 * sonar, seed)
    prior = UNCALIBRATED if recording.vehicle.name == "omnimate" else LEFT_BEHIND
    return {name: lap_errors(recording, path_of(recording, name, seen, prior), seen) for name in estimators}


def path_of(recording: Recording, name: Estimator, seen: Poses, prior: Prior) -> Array:
    """Return the path `(N, 3)` of truck a by an estimator, from the first fix on."""
    start = seen.pose[0]
    if name in {"plain", "dead band"}:
        return correct(recording, start, method="plain" if name == "plain" else "clapper").pose_a
    if name in {"CLAPPER", "OmniMate"}:
        return as_derived(recording, start, "clapper" if name == "CLAPPER" else "omnimate")
    run = estimate if name == "filter" else smooth
    return run(recording, start, seen.sigma[0], prior=prior).pose_a


def as_derived(recording: Recording, start: Array, method: Method) -> Array:
    """Return the path `(N, 3)` of truck a by C (12)-(13) or O (3)-(4): the whole difference is an error."""
    counts, present = ordered_counts(recording)
    corrector = Corrector(recording.vehicle, method)
    corrector.settings["tolerance"] = 0.0
    state = corrector.start(start).record.copy()
    poses, corrections = np.empty((2, len(counts), 3)), np.empty((len(counts), 3))
    advance_all(corrector.settings, state, counts, present, poses, corrections)
    return np.asarray(poses[0])


def measured(recording: Recording, sonar: Array, seed: int) -> Poses:
    """Return the exact fixes of truck a with the noise of a sonar of half widths `(3,)`."""
    assert recording.poses is not None
    fixes = recording.poses.of("a")
    noise = np.random.default_rng(seed).uniform(-1.0, 1.0, size=fixes.pose.shape) * sonar
    sigma = np.tile(sonar / math.sqrt(3.0), (len(fixes.time), 1))
    return Poses(fixes.time, fixes.body, fixes.pose + noise, sigma)


def sizes(errors: Array) -> tuple[Array, Array]:
    """Return distance [mm] and |heading| [degrees], `(..., L)` each, of return errors `(..., L, 3)`."""
    return 1e3 * np.hypot(errors[..., 0], errors[..., 1]), np.degrees(np.abs(errors[..., 2]))


# The values of a figure of each robot `(n,)` without one cause of error.
Figure = Callable[[Term], Array]

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


def straight_line(count: int) -> tuple[Row, ...]:
    """Return the rows of C 6.1 over `count` robots."""
    rows: list[Row] = []
    for bumps in (0, 10):
        which = f"{2 * bumps} bumps" if bumps else "no bumps"
        for name in ESTIMATORS:
            what = f"worst heading of 3 runs, {name}, {which} [deg]"
            figure = _over(count, partial(straight_errors, bumps=bumps), partial(_worst_heading, name))
            rows.append(bounded("C", "6.1", what, figure, 1.0 if name == "CLAPPER" else None, 2))
    turned = _over(count, partial(straight_errors, bumps=10), _turned)("nothing")
    what = "mean heading, plain, 10 bumps under each truck [deg]"
    return (*rows, drawn("C", "6.1", what, "6.0", turned, judged(good=5.0 < turned.mean() < 7.0), 2))


def rectangular_path(count: int) -> tuple[Row, ...]:
    """Return the rows of C 6.2 over `count` robots: 10 + 10 runs with bumps, 5 + 5 without."""
    rows: list[Row] = []
    for bumps in (0, 10):
        which = f"{bumps} bumps" if bumps else "no bumps"
        errors_of = partial(rectangle_errors, bumps=bumps)
        for name in ESTIMATORS:
            for words, value, bound, digits in (
                ("worst position, {} [mm]", _worst_position, 50.0, 0),
                ("mean |heading|, {} [deg]", _mean_heading, 0.3, 2),
            ):
                what = words.format(f"{name}, {which}")
                wanted = bound if bumps and name == "CLAPPER" else None
                rows.append(
                    bounded("C", "6.2", what, _over(count, errors_of, partial(value, name)), wanted, digits)
                )
    gain = _over(count, partial(rectangle_errors, bumps=10), _gain)
    return (*rows, _reduction("C", "6.2", "mean |heading| without / with IPEC, bumps", 20.0, gain))


def omnimate_laps(count: int) -> tuple[Row, ...]:
    """Return O 3 and its Table I over `count` robots: laps 1-10 with IPEC, 1-9 without."""
    rows: list[Row] = []
    for column, (what, with_ipec, without) in enumerate(TABLE_I):
        digits = 0 if "mm" in what else 2
        figures = {name: _over(count, columns_of, partial(_column, name, column)) for name in ESTIMATORS}
        for name, figure in figures.items():
            if name == "plain":
                rows.append(_plain(what, without, figure("nothing"), digits))
                continue
            bound = with_ipec if name == "OmniMate" else None
            rows.append(bounded("O", "Table I", f"{what}, {name}", figure, bound, digits))

        def gain(term: Term, figures: dict[Estimator, Figure] = figures) -> Array:
            return figures["plain"](term) / figures["OmniMate"](term)

        rows.append(_reduction("O", "Table I", f"{what}, without / with IPEC", 10.0, gain))
    return tuple(rows)


def _over(count: int, errors_of: Callable[..., Errors], value: Callable[[Errors], float]) -> Figure:
    """Return the figure that `value` makes of the errors of `count` robots."""
    return lambda term: np.array([value(errors_of(seed, without=term)) for seed in range(count)])


def bounded(paper: str, place: str, what: str, figure: Figure, bound: float | None, digits: int) -> Row:
    """Return the row of a figure that must lie below a bound, if any, with its error budget."""
    values = figure("nothing")
    if bound is None:
        return drawn(paper, place, what, "-", values, "shown", digits)
    return explained(at_most(paper, place, what, bound, values, digits), figure, digits)


def _reduction(paper: str, place: str, what: str, bound: float, figure: Figure) -> Row:
    """Return the row of a ratio that must lie above a bound, with its error budget."""
    return explained(at_least(paper, place, what, bound, figure("nothing")), figure, 1)


def _plain(what: str, printed: float, values: Array, digits: int) -> Row:
    """Return the row of plain odometry, whose errors depend on wheels that the paper does not describe."""
    verdict = judged(good=0.5 < values.mean() / printed < 2.0, otherwise="unexplained")
    return drawn("O", "Table I", f"{what}, plain", f"{printed:g}", values, verdict, digits)


POSITION, HEADING = 0, 1  # of `sizes`


def _size(size: int, over_runs: Callable[[Array], float], name: Estimator, errors: Errors) -> float:
    """Return the largest or the mean position [mm] or heading [degrees] of the runs of an estimator."""
    return float(over_runs(sizes(errors[name])[size]))


_worst_heading, _worst_position = partial(_size, HEADING, np.max), partial(_size, POSITION, np.max)
_mean_heading = partial(_size, HEADING, np.mean)


def _gain(errors: Errors) -> float:
    return _mean_heading("plain", errors) / _mean_heading("CLAPPER", errors)


def _column(name: Estimator, column: int, columns: Errors) -> float:
    return float(columns[name][column])


def _turned(errors: Errors) -> float:
    return float(abs(np.degrees(errors["plain"][:, 2].mean())))


@cache
def straight_errors(seed: int, bumps: int, without: Term = "nothing") -> Errors:
    """Return the return errors `(3, 3)` of C 6.1 by estimator."""
    drive = straight(seed, bumps, without)
    return return_errors(drive, CLAPPER_SONAR, seed, without)


@cache
def rectangle_errors(seed: int, bumps: int, without: Term = "nothing") -> Errors:
    """Return the return errors of C 6.2 by estimator, cw then ccw: `(20, 3)`, without bumps `(10, 3)`."""
    runs = 10 if bumps else 5
    cw, ccw = (
        return_errors(
            rectangle(seed, way, runs, bumps, without), CLAPPER_SONAR, 2 * seed + (way == "cw"), without
        )
        for way in ("cw", "ccw")
    )
    return {name: np.concatenate([cw[name], ccw[name]]) for name in cw}


@cache
def lap_errors_of(seed: int, way: Turning, without: Term = "nothing") -> Errors:
    """Return the return errors `(10, 3)` of O 3 by estimator."""
    return return_errors(laps(seed, way, without), OMNIMATE_SONAR, 2 * seed + (way == "cw"), without)


@cache
def columns_of(seed: int, without: Term = "nothing") -> Errors:
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
