"""UMBmark's numbers that need no chance: Fig. 11, the cost of small angles, the scale left in."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from omnimate.calib.apply import corrected_truck
from omnimate.calib.umbmark.exact import solve_exact, square_returns
from omnimate.calib.umbmark.experiment import Experiment, calibrate
from omnimate.calib.umbmark.printed import Correction
from omnimate.calib.umbmark.return_errors import ReturnErrors
from studies.papers.rows import Row, number
from studies.papers.trials import LABMATE

if TYPE_CHECKING:
    from omnimate.vehicle.parameters import Truck

SIDE = 4.0  # [m]
AFTER = (21.0, 32.0, 31.0, 14.0, 26.0, 35.0, 20.0, 12.0)  # [mm] U Table I, #7 after its second pass
SMALL_ANGLES = (
    ((336.17 / 340.0, 1.00084), (311.0, 3.5, 0.0)),
    ((0.95, 1.005), (1507.0, 138.0, 0.6)),
    ((0.90, 1.02), (3610.0, 1960.0, 281.0)),
)  # E_b and E_d; E_max,syst before, after one pass, after two [mm]


def square_numbers() -> tuple[Row, ...]:
    """Return all rows."""
    return (*figure_11(), *small_angles(), *table_i(), scale_left_in())


def figure_11() -> tuple[Row, ...]:
    """Return what b = 336.17 mm and D_R/D_L = 1.00084 imply, U (4.20)-(4.32)."""
    e_b, e_d = 336.17 / 340.0, 1.00084
    alpha = 0.5 * math.pi * (1.0 - 1.0 / e_b)
    beta = 2.0 * math.asin(SIDE / LABMATE.wheelbase * (e_d - 1.0) / (e_d + 1.0))
    small = 2e3 * math.sqrt(2.0) * SIDE * max(abs(alpha + beta), abs(alpha - beta))
    exact = largest(LABMATE, corrected_truck(LABMATE, e_b, e_d))
    correction = Correction("printed", alpha, beta, e_b, e_d)
    return (
        number("U", "Fig. 11", "alpha [deg]", -1.025, math.degrees(alpha), 3),
        number("U", "Fig. 11", "beta [deg]", 0.566, math.degrees(beta), 3),
        number("U", "Fig. 11", "c_L", 0.99958, correction.c_left, 5),
        number("U", "Fig. 11", "c_R", 1.00042, correction.c_right, 5),
        number("U", "Fig. 11", "E_max before, small angles [mm]", 314.0, small, 0),
        number("U", "Fig. 11", "E_max before, exact chain [mm]", 311.0, exact, 0),
        Row(
            "U",
            "Fig. 11",
            "E_max before, of its own b and E_d [mm]",
            "317",
            f"{small:.0f}, {exact:.0f}",
            "misprint",
        ),
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


def table_i() -> tuple[Row, ...]:
    """Return the arithmetic of Table I and of the stop rule."""
    sem = 25.0 / math.sqrt(5.0)
    return (
        number("U", "Table I", "mean E_max after [mm]", 23.9, float(np.mean(AFTER)), 1),
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
