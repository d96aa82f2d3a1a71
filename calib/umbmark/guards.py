"""Guards against errors in the data of a UMBmark, with the remedy for each.

Each guard compares the measurements with what a robot of wrong wheelbase and diameters can produce, in units
of the scatter of the runs. Each of the three statistical guards raises a false alarm in 1 of 1000 healthy
experiments; tests count it.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from omnimate.calib.advice import Advice, Severity
from omnimate.calib.apply import corrected_truck
from omnimate.calib.distributions import fisher_tail
from omnimate.calib.umbmark.exact import solve_exact, square_returns
from omnimate.calib.umbmark.return_errors import MIRROR
from omnimate.calib.umbmark.square import factor_ends
from omnimate.calib.umbmark.uncertainty import factor_slopes

if TYPE_CHECKING:
    from omnimate.calib.umbmark.experiment import Experiment
    from omnimate.calib.umbmark.return_errors import ReturnErrors
    from omnimate.calib.umbmark.runs import SquareDirection
    from omnimate.vehicle.se2 import Array

CHANCE = 1e-3  # probability that a guard raises a false alarm
_OFF_DIAGONAL = 0.25  # [E_max,syst] an error of another kind that is smaller does no harm
_FEW = 4  # degrees of freedom; with fewer, the scatter itself is hardly known
_FAR = math.radians(4.0)  # no floor on which a robot may be calibrated changes a heading by more
_QUARTER = 0.5 * math.pi
_LEAST_HEADING = math.radians(0.5)  # smallest predicted heading for which a ratio to it is meaningful
_RATIOS = (
    (180.0 / math.pi, "degrees stand where radians are expected", "write the headings as theta_deg"),
    (math.pi / 180.0, "radians stand where degrees are expected", "write the headings as theta_rad"),
    (4.0, "the side is the whole path", "give the length of one leg as --side"),
    (-1.0, "the headings have the wrong sign", "count them counter-clockwise, absolute minus calculated"),
)


def advise(experiment: Experiment) -> tuple[Advice, ...]:
    """Return advice on everything that looks wrong with an experiment; none for healthy data."""
    errors = experiment.errors
    guards = (*_few_runs(errors), *_large(errors), *_missing_turn(errors))
    if any(advice.severity == "error" for advice in guards):
        return guards
    return (*guards, *_off_diagonals(experiment), *_headings(experiment))


def without_outliers(experiment: Experiment) -> tuple[Experiment, tuple[Advice, ...]]:
    """Return an experiment without the runs that are far from the others, the farthest first, and which."""
    numbers = {"cw": list(range(1, len(experiment.errors.cw) + 1))}
    numbers["ccw"] = list(range(1, len(experiment.errors.ccw) + 1))
    advice = []
    while outliers := _outliers(experiment.errors):
        name, place, distance = min(outliers)[1:]
        run = f"{name} run {numbers[name].pop(place)}"
        experiment = experiment.without(name, place)
        what = f"{run} is left out: it returns {1e3 * distance:.0f} mm away from the other {name} runs"
        advice.append(Advice("warning", what, "measure its fixes again, or drive it again"))
    return experiment, tuple(advice)


def _few_runs(errors: ReturnErrors) -> tuple[Advice, ...]:
    single = [name for name, count in zip(("cw", "ccw"), errors.runs, strict=True) if count == 1]
    if not single:
        return ()
    severity: Severity = "error" if len(single) == 2 else "warning"
    what = (
        f"n = 1: a single run {' and a single run '.join(single)}, so that the scatter of the runs is unknown"
    )
    return (Advice(severity, what, "drive the square five times in each direction"),)


def _large(errors: ReturnErrors) -> tuple[Advice, ...]:
    """Find return errors above the side of the square: true of very different wheels, or of a wrong unit."""
    if errors.worst <= errors.side:
        return ()
    what = f"a return error of {errors.worst:.3g} m in a square of {errors.side:g} m: is the unit right?"
    return (Advice("warning", what, "check the unit; if it is true, calibrate, drive again, and repeat"),)


def _missing_turn(errors: ReturnErrors) -> tuple[Advice, ...]:
    """Find return headings that are a quarter turn short in both directions."""
    if not errors.has_headings:
        return ()
    headings = MIRROR[2] * errors.centres[0, 2], errors.centres[1, 2]
    if not all(abs(heading + _QUARTER) < 0.5 * _QUARTER for heading in headings):
        return ()
    what = "the return headings are a quarter turn short: the last turn is missing"
    return (Advice("error", what, "turn four times, also after the last leg, and measure after it"),)


def _outliers(errors: ReturnErrors) -> list[tuple[float, SquareDirection, int, float]]:
    """Return the runs improbably far from the others of their direction, by Hotelling's T^2.

    Each is its probability, its direction, its place from 0, and its distance from the others [m].
    """
    outliers: list[tuple[float, SquareDirection, int, float]] = []
    both: tuple[tuple[SquareDirection, Array, Array], ...] = (
        ("cw", errors.cw, errors.ccw),
        ("ccw", errors.ccw, errors.cw),
    )
    for name, runs, other in both:
        for number in range(len(runs) if len(runs) >= 3 else 0):
            chance, distance = _chance_of(runs[number], np.delete(runs, number, axis=0), other)
            if chance * sum(errors.runs) < CHANCE and distance > 1e-6 * errors.side:
                outliers.append((chance, name, number, distance))
    return outliers


def _chance_of(run: Array, rest: Array, other: Array) -> tuple[float, float]:
    """Return the probability that a run lies so far from the rest of its direction, and its distance [m]."""
    away = (run - rest.mean(axis=0))[:2]
    mirrored = (other - other.mean(axis=0)) * MIRROR
    deviations = np.concatenate([rest - rest.mean(axis=0), mirrored])[:, :2]
    freedom = len(deviations) - 2
    scatter = deviations.T @ deviations / freedom
    if freedom < 3 or np.linalg.det(scatter) <= 0.0:
        return 1.0, 0.0
    squared = away @ np.linalg.solve(scatter, away) / (1.0 + 1.0 / len(rest))
    return fisher_tail(squared * (freedom - 1) / (2.0 * freedom), 2, freedom - 1), float(np.hypot(*away))


def _off_diagonals(experiment: Experiment) -> tuple[Advice, ...]:
    """Find centres of gravity off the diagonals on which U (4.17) and (4.18) put them."""
    errors, truck = experiment.errors, experiment.truck
    if errors.freedom == 0:
        return ()
    correction = solve_exact(errors, truck)
    chain = square_returns(truck, corrected_truck(truck, correction.e_b, correction.e_d), errors.side)
    across = np.array([math.sqrt(0.5), math.sqrt(0.5)])  # of the ccw diagonal; cw is mirrored
    rest = ((errors.centres - chain) * np.stack([MIRROR, np.ones(3)]))[:, :2] @ across
    variance = across @ errors.covariance[:2, :2] @ across
    if (
        variance <= 0.0
        or fisher_tail(0.5 * np.sum(errors.runs * rest**2) / variance, 2, errors.freedom) >= CHANCE
    ):
        return ()
    size = float(np.abs(rest).max())
    what = (
        f"the clusters lie {1e3 * size:.1f} mm off their diagonals; neither wheelbase nor diameters do that"
    )
    if size < _OFF_DIAGONAL * errors.e_max_syst:
        return (
            Advice(
                "note", what, "it is small beside the rest; misaligned wheels or the fixes' frame may do it"
            ),
        )
    do = "check the frame of the fixes (x along the first leg, y to its left) and that all legs are equal"
    return (Advice("warning", what, do),)


def _headings(experiment: Experiment) -> tuple[Advice, ...]:
    """Find headings that contradict the positions, and the cause where their ratio shows it."""
    errors, truck = experiment.errors, experiment.truck
    if not errors.has_headings:
        return ()
    correction = solve_exact(errors, truck)
    factors = np.array([correction.e_b, correction.e_d])
    ends, by_logs = factor_ends(truck, errors.side, np.log(factors))
    predicted, measured = ends[:, 2], errors.centres[:, 2]
    if not _contradict(experiment, measured - predicted, by_logs[:, 2, :] / factors):
        return ()
    size = float(np.hypot(*predicted))
    ratio = float(measured @ predicted) / size**2 if size > _LEAST_HEADING else math.nan
    for wanted, what, do in _RATIOS:
        if 0.6 < ratio / wanted < 1.6:
            return (
                Advice("error", f"the headings are {ratio:.3g} times what the positions say: {what}", do),
            )
    worst = math.degrees(float(np.abs(measured - predicted).max()))
    what = f"the return headings differ by {worst:.2f} degrees from what the positions say"
    return (Advice("warning", what, "check how headings are measured; --method exact does without them"),)


def _contradict(experiment: Experiment, rest: Array, by_factors: Array) -> bool:
    """Return whether headings differ from those that positions predict by more than the runs' scatter.

    `rest` `(2,)` are the differences [rad], cw then ccw; `by_factors` `(2, 2)` the slopes of the predicted
    headings by E_b and E_d.
    """
    errors = experiment.errors
    if errors.freedom < _FEW and np.abs(rest).max() > _FAR:
        return True
    if errors.freedom < 2:
        return False
    slopes = -by_factors @ factor_slopes(experiment, "exact")
    slopes[[0, 1], [2, 5]] += 1.0
    covariance = slopes @ errors.covariance_of_centres @ slopes.T
    if np.linalg.det(covariance) <= 0.0:
        return bool(np.abs(rest).max() > math.radians(0.1))
    squared = rest @ np.linalg.solve(covariance, rest)
    freedom = errors.freedom
    return fisher_tail(float(squared) * (freedom - 1) / (2.0 * freedom), 2, freedom - 1) < CHANCE
