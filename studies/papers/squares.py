"""The numbers of U: its equations, the statistics of the method, and its Table I."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from omnimate.calib.apply import corrected_truck, factors_between
from omnimate.calib.umbmark.exact import solve_exact, square_returns
from omnimate.calib.umbmark.experiment import Experiment, calibrate, experiment_of_recordings
from omnimate.calib.umbmark.return_errors import ReturnErrors
from omnimate.motion.paths import umbmark
from omnimate.vcan_sim.reference import reference_single
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth, with_errors
from omnimate.vehicle.parameters import Truck, VehicleParameters
from omnimate.vehicle.se2 import Array
from studies.papers.rows import Row, Verdict, drawn, interval, judged, number
from studies.papers.trials import (
    LABMATE,
    SIDE,
    Trial,
    after_calibration,
    efficiency,
    floor_covariance,
    left_over,
    plain_covariance,
)

FIGURE_11 = (336.17 / 340.0, 1.00084)
# E_max,syst [mm] before, after, after a second pass where there was one; U Table I, #1 to #8.
TABLE_I = ((317, 21), (349, 32), (310, 31), (310, 14), (310, 26), (403, 35), (423, 66, 20), (232, 12))
_ALPHA = math.radians(-1.025)  # the same robot throughout; the tape of #7 and #8 changes one diameter
SMALL_ANGLES = (
    (FIGURE_11, (311.0, 3.5, 0.0)),
    ((0.95, 1.005), (1507.0, 138.0, 0.6)),
    ((0.90, 1.02), (3610.0, 1960.0, 281.0)),
)  # E_b and E_d; E_max,syst before, after one pass, after two [mm]


def square_numbers() -> tuple[Row, ...]:
    return (*figure_11(), *small_angles(), *stop_rule(), scale_left_in())


def figure_11() -> tuple[Row, ...]:
    """Return what b = 336.17 mm and D_R/D_L = 1.00084 imply, U (4.20)-(4.32)."""
    e_b, e_d = FIGURE_11
    alpha = 0.5 * math.pi * (1.0 - 1.0 / e_b)
    beta = 2.0 * math.asin(SIDE / LABMATE.wheelbase * (e_d - 1.0) / (e_d + 1.0))
    small = 2e3 * math.sqrt(2.0) * SIDE * max(abs(alpha + beta), abs(alpha - beta))
    actual = corrected_truck(LABMATE, e_b, e_d)
    exact, factors = largest(LABMATE, actual), factors_between(LABMATE, actual)
    both = f"{small:.0f}, {exact:.0f}"
    return (
        number("U", "Fig. 11", "alpha [deg]", -1.025, math.degrees(alpha), 3),
        number("U", "Fig. 11", "beta [deg]", 0.566, math.degrees(beta), 3),
        number("U", "Fig. 11", "c_L", 0.99958, factors.c_left, 5),
        number("U", "Fig. 11", "c_R", 1.00042, factors.c_right, 5),
        number("U", "Fig. 11", "E_max before, small angles [mm]", 314.0, small, 0),
        number("U", "Fig. 11", "E_max before, exact chain [mm]", 311.0, exact, 0),
        Row("U", "Fig. 11", "E_max before, of its own b and E_d [mm]", "317", both, "misprint"),
    )


def small_angles() -> tuple[Row, ...]:
    """Return what the small-angle formulas leave without any noise, and what the exact chain leaves."""
    rows = []
    for (e_b, e_d), (before, first, second) in SMALL_ANGLES:
        actual = corrected_truck(LABMATE, e_b, e_d)
        where, at = "(4.17)-(4.32)", f"at E_b {e_b:.4g}, E_d {e_d:.6g} [mm]"
        once = calibrate(experiment(LABMATE, actual), "printed").truck
        twice = calibrate(experiment(once, actual), "printed").truck
        exact = calibrate(experiment(LABMATE, actual), "exact").truck
        digits = _digits(before), _digits(first), _digits(second)
        rows += [
            number("U", where, f"E_max before {at}", before, largest(LABMATE, actual), digits[0]),
            number("U", where, f"E_max after one pass {at}", first, largest(once, actual), digits[1]),
            number("U", where, f"E_max after two passes {at}", second, largest(twice, actual), digits[2]),
            number("U", where, f"E_max after exact inversion {at}", 0.0, largest(exact, actual), 3),
        ]
    return tuple(rows)


def _digits(size: float) -> int:
    """Return how many decimals NOTES gives a size [mm]; from 1.9 m on three figures of it."""
    return 1 if size < 100.0 else 0 if size < 1900.0 else -1


def stop_rule() -> tuple[Row, ...]:
    """Return the arithmetic of Table I and of the stop rule."""
    sem, after = 25.0 / math.sqrt(5.0), float(np.mean([row[-1] for row in TABLE_I]))
    return (
        number("U", "Table I", "mean E_max after [mm]", 23.9, after, 1),
        number("U", "V", "SEM of 25 mm and 5 runs [mm]", 11.2, sem, 1),
        number("U", "V", "3 SEM, of the rounded SEM [mm]", 33.6, 3.0 * round(sem, 1), 1),
    )


def scale_left_in() -> Row:
    """Return what the square makes of a mean diameter that is wrong by 1 %."""
    larger = replace(LABMATE, wheel_diameter_left=0.1515, wheel_diameter_right=0.1515)
    correction = solve_exact(experiment(LABMATE, larger).errors, LABMATE)
    return number("U", "E_s", "E_b read from E_s = 1.01", 1.0 / 1.01, correction.e_b, 3)


def experiment(believed: Truck, actual: Truck) -> Experiment:
    """Return an experiment of one exact run in each direction."""
    cw, ccw = square_returns(believed, actual, SIDE)
    return Experiment("exact square", believed, ReturnErrors(cw[None], ccw[None], SIDE, "exact square"))


def largest(believed: Truck, actual: Truck) -> float:
    """Return E_max,syst of exact squares [mm]."""
    ends = square_returns(believed, actual, SIDE)
    return float(1e3 * np.hypot(ends[:, 0], ends[:, 1]).max())


def statistics(count: int) -> tuple[Row, ...]:
    """Return the rows of `count` trials of the method: the errors that it leaves, and its variance."""
    after = 1e3 * after_calibration(Trial(*FIGURE_11, floor_covariance(0.025)), count)
    low, high = np.percentile(after, [5.0, 95.0])
    near = judged(good=abs(after.mean() - 24.0) <= 1.0 or interval(after)[0] <= 24.0 <= interval(after)[1])
    within = bool(abs(low - 9.0) <= 2.0 and abs(high - 47.0) <= 4.0)
    rows = [
        drawn("U", "Table I", "mean E_max after, 25 mm of scatter [mm]", "24.0 +- 1", after, near),
        Row("U", "Table I", "5 to 95 % of it [mm]", "9..47", f"{low:.0f}..{high:.0f}", judged(good=within)),
    ]
    for factors, printed in ((FIGURE_11, 17.0), ((0.95, 1.005), 140.0)):
        trial = Trial(*factors, floor_covariance(0.022))
        where = f"at E_b {factors[0]:.4g}, E_d {factors[1]:.6g} [mm]"
        plain = 1e3 * left_over(trial, max(count // 4, 100), "printed")
        near = judged(good=abs(plain.mean() - printed) < 3.0)
        rows.append(drawn("U", "22 mm scatter", f"left by the print {where}", f"{printed:g}", plain, near))
        for method in ("exact", "weighted"):
            values = 1e3 * left_over(trial, max(count // 4, 100), method)
            verdict: Verdict = "better" if interval(values)[1] < 15.5 else "agrees"
            if interval(values)[0] > 16.5:
                verdict = "differs"
            what = f"left by the {method} fit {where}"
            rows.append(drawn("N", "22 mm scatter", what, "16", values, verdict))
    return (*rows, *variances(50 * count))


def variances(count: int) -> tuple[Row, ...]:
    """Return the weighted fit's variance over the Cramer-Rao bound, from `count` trials."""
    trial = Trial(*FIGURE_11, plain_covariance(0.022))
    rows = []
    for estimated, words in ((False, "true weights"), (True, "own weights")):
        ratio = efficiency(trial, count, estimated_weights=estimated)
        verdict: Verdict = "agrees" if np.abs(ratio - 1.0).max() <= 0.05 else "missed"
        error = 1.96 * math.sqrt(2.0 / count)
        ours = f"{ratio[0]:.3f}, {ratio[1]:.3f} (+- {error:.3f})"
        note = "its weights are estimated from 5 + 5 runs alone" if verdict == "missed" else ""
        what = f"variance of E_b, E_d over the bound, {words}"
        rows.append(Row("N", "Cramer-Rao", what, "1 +- 0.05", ours, verdict, note=note))
    return tuple(rows)


def table_i(number: int, count: int) -> tuple[Row, ...]:
    """Return experiment `number` (from 0) of U Table I, driven `count` times with 25 mm of scatter."""
    printed = TABLE_I[number]
    passes = np.array([passes_of(_factors(printed[0]), 100 * number + seed) for seed in range(count)])
    rows = []
    for stage, words in enumerate(("before", "after", "after a second pass")):
        values = passes[:, stage]
        paper = str(printed[stage]) if stage < len(printed) else "-"
        verdict: Verdict = "shown"
        if stage < len(printed):
            low, high = values.min(), values.max()
            inside = low - 10.0 <= printed[stage] <= high + 10.0
            verdict = "agrees" if inside else "unexplained" if printed[stage] == 66 else "differs"
        rows.append(drawn("U", f"Table I, #{number + 1}", f"E_max {words} [mm]", paper, values, verdict))
    return tuple(rows)


def passes_of(factors: tuple[float, float], seed: int) -> Array:
    """Return E_max,syst `(3,)` before, after one, and after two passes of a UMBmark [mm]."""
    return np.array([1e3 * errors.e_max_syst for errors in stages_of(factors, seed)])


def stages_of(factors: tuple[float, float], seed: int) -> list[ReturnErrors]:
    """Return the return errors before calibration, after one, and after two passes, each driven again."""
    robot: VehicleParameters = reference_single()
    real = with_errors(robot, {"a": factors[0]}, {"a": factors[1]})
    stages = []
    for stage in range(3):
        drive = simulate(robot, Truth(real, seed=3 * seed + stage), umbmark())
        experiment = experiment_of_recordings([drive])
        stages.append(experiment.errors)
        robot = robot.with_truck("a", calibrate(experiment, "printed").truck)
    return stages


def _factors(before: float) -> tuple[float, float]:
    """Return E_b and E_d of a robot with E_max before [mm], to first order 2 sqrt(2) L (|alpha| + |beta|)."""
    beta = 1e-3 * before / (2.0 * math.sqrt(2.0) * SIDE) - abs(_ALPHA)
    half = LABMATE.wheelbase * math.sin(0.5 * beta) / SIDE
    return 0.5 * math.pi / (0.5 * math.pi - _ALPHA), (1.0 + half) / (1.0 - half)
