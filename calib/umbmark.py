"""UMBmark as printed: from two centres of gravity to E_b and E_d by small-angle formulas, U (4.17)-(4.32).

The print gives angles in degrees; here they are radians throughout, as (4.21) needs them. alpha > 0: every
corner turns less than 90 degrees. beta > 0: every leg curves to the left.

The paper computes E_d before it corrects the wheelbase, hence with the nominal b in (4.22), and all of its
figures follow so. The curve of a leg is truly that of the actual b; `true_wheelbase` takes that one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from calib.errors import CalibrationError

if TYPE_CHECKING:
    from calib.return_errors import ReturnErrors

Method = Literal["printed-x", "printed-y", "printed", "printed-true-b", "exact"]


@dataclass(frozen=True, slots=True)
class Correction:
    """What a UMBmark experiment says about a truck.

    Attributes:
        method: how it was found.
        alpha: heading missing at each corner [rad], type A error.
        beta: heading gained along each leg [rad], type B error.
        e_b: actual over nominal wheelbase, U (2.4).
        e_d: actual over nominal ratio of right to left wheel diameter, U (2.3).
    """

    method: Method
    alpha: float
    beta: float
    e_b: float
    e_d: float

    @property
    def c_left(self) -> float:
        """Correction factor of the left wheel, U (4.31)."""
        return 2.0 / (self.e_d + 1.0)

    @property
    def c_right(self) -> float:
        """Correction factor of the right wheel, U (4.32)."""
        return 2.0 / (1.0 / self.e_d + 1.0)


def angles_from_x(errors: ReturnErrors) -> tuple[float, float]:
    """Return alpha and beta [rad] from the x components, U (4.24a) and (4.20a)."""
    cw, ccw = errors.centres[:, 0]
    return float((cw + ccw) / (-4.0 * errors.side)), float((cw - ccw) / (-4.0 * errors.side))


def angles_from_y(errors: ReturnErrors) -> tuple[float, float]:
    """Return alpha and beta [rad] from the y components, U (4.24b) and (4.20b)."""
    cw, ccw = errors.centres[:, 1]
    return float((cw - ccw) / (-4.0 * errors.side)), float((cw + ccw) / (-4.0 * errors.side))


def wheelbase_factor(alpha: float) -> float:
    """Return E_b for alpha [rad], U (4.27)."""
    return 0.5 * math.pi / (0.5 * math.pi - alpha)


def diameter_ratio(beta: float, side: float, wheelbase: float) -> float:
    """Return E_d for beta [rad] on legs of `side` [m], U (4.21) and (4.22) without the infinite radius."""
    half = wheelbase * math.sin(0.5 * beta) / side  # b / (2 R)
    return (1.0 + half) / (1.0 - half)


def solve_printed(errors: ReturnErrors, wheelbase: float, method: Method = "printed") -> Correction:
    """Return the correction by the paper's equations.

    Args:
        errors: of the runs.
        wheelbase: the nominal one, with which the odometry was calculated [m].
        method: from x alone, from y alone, or both averaged as in footnote 2, with the nominal b in (4.22);
            "printed-true-b" averages too and takes the corrected b.

    Raises:
        CalibrationError: the errors are beyond what small angles can mean.
    """
    angles = {"printed-x": [angles_from_x(errors)], "printed-y": [angles_from_y(errors)]}.get(
        method, [angles_from_x(errors), angles_from_y(errors)]
    )
    if any(abs(angle) >= 0.25 * math.pi for pair in angles for angle in pair):
        raise CalibrationError(
            errors.source,
            f"return errors of {1e3 * errors.e_max_syst:.0f} mm on a square of {errors.side:g} m mean more "
            "than 45 degrees at a corner; check the units and the side (one leg, not the whole path)",
        )
    factors = []
    for alpha, beta in angles:
        e_b = wheelbase_factor(alpha)
        taken = wheelbase * e_b if method == "printed-true-b" else wheelbase
        factors.append((alpha, beta, e_b, diameter_ratio(beta, errors.side, taken)))
    alpha, beta, e_b, e_d = (sum(values) / len(factors) for values in zip(*factors, strict=True))
    return Correction(method, alpha, beta, e_b, e_d)
