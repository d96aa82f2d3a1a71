"""UMBmark by Monte Carlo: Table I on a simulated floor, and the statistics of the method."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from omnimate.calib.umbmark.experiment import calibrate, experiment_of_recordings
from omnimate.motion.paths import umbmark
from omnimate.vcan_sim.reference import reference_single
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth, with_errors
from studies.papers.rows import Row, drawn, interval
from studies.papers.trials import (
    Trial,
    after_calibration,
    efficiency,
    floor_covariance,
    left_over,
    plain_covariance,
)

if TYPE_CHECKING:
    from omnimate.calib.umbmark.return_errors import ReturnErrors
    from omnimate.vehicle.parameters import VehicleParameters
    from omnimate.vehicle.se2 import Array
    from studies.papers.rows import Verdict

FIGURE_11 = (336.17 / 340.0, 1.00084)
# E_max,syst [mm] before, after, after a second pass where there was one; U Table I, #1 to #8.
TABLE_I = ((317, 21), (349, 32), (310, 31), (310, 14), (310, 26), (403, 35), (423, 66, 20), (232, 12))
_ALPHA = math.radians(-1.025)  # the same robot throughout; the tape of #7 and #8 changes one diameter
_SIDE, _BASE = 4.0, 0.340  # [m]


def statistics(count: int) -> tuple[Row, ...]:
    """Return the rows of `count` trials of the method: the errors that it leaves, and its variance."""
    after = 1e3 * after_calibration(Trial(*FIGURE_11, floor_covariance(0.025)), count)
    low, high = np.percentile(after, [5.0, 95.0])
    near = abs(after.mean() - 24.0) <= 1.0 or interval(after)[0] <= 24.0 <= interval(after)[1]
    within = abs(low - 9.0) <= 2.0 and abs(high - 47.0) <= 4.0
    rows = [
        _drawn("Table I", "mean E_max after, 25 mm of scatter [mm]", "24.0 +- 1", after, good=near),
        Row(
            "U",
            "Table I",
            "5 to 95 % of it [mm]",
            "9..47",
            f"{low:.0f}..{high:.0f}",
            "agrees" if within else "differs",
        ),
    ]
    for factors, printed in ((FIGURE_11, 17.0), ((0.95, 1.005), 140.0)):
        trial = Trial(*factors, floor_covariance(0.022))
        where = f"at E_b {factors[0]:.4g}, E_d {factors[1]:.6g} [mm]"
        plain = 1e3 * left_over(trial, max(count // 4, 100), "printed")
        rows.append(
            _drawn(
                "22 mm scatter",
                f"left by the print {where}",
                f"{printed:g}",
                plain,
                good=abs(plain.mean() - printed) < 3.0,
            )
        )
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
    """Return the return errors before calibration, after one, and after two passes, each driven anew."""
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
    beta = 1e-3 * before / (2.0 * math.sqrt(2.0) * _SIDE) - abs(_ALPHA)
    half = _BASE * math.sin(0.5 * beta) / _SIDE
    return 0.5 * math.pi / (0.5 * math.pi - _ALPHA), (1.0 + half) / (1.0 - half)


def _drawn(place: str, what: str, printed: str, values: Array, *, good: bool) -> Row:
    return drawn("U", place, what, printed, values, "agrees" if good else "differs")
