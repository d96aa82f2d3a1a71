"""All steps from the runs to the correction factors, for a check by hand."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from omnimate.calib.umbmark.printed import printed_angles

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.calib.umbmark.return_errors import ReturnErrors
    from omnimate.vehicle.parameters import Truck


@dataclass(frozen=True, slots=True)
class Step:
    """One line of the calculation."""

    number: str  # number of the formula in U
    symbol: str  # symbol of the result
    how: str  # the formula with numbers inserted
    value: float  # the result in millimetres, in degrees, or as a factor without unit
    unit: str = ""  # unit of the result: mm, deg or empty


def worksheet(errors: ReturnErrors, truck: Truck) -> tuple[Step, ...]:
    """Return every step of U (3.2) to (4.33) in order, x and y averaged as in footnote 2."""
    x, y = printed_angles(errors.centres, errors.side).tolist()
    by_x = _factors("x", x, errors.side, truck.wheelbase)
    by_y = _factors("y", y, errors.side, truck.wheelbase)
    return (
        *_clusters(errors),
        *_angles(errors, x, y),
        *by_x,
        *by_y,
        *_means(by_x, by_y, truck),
    )


def _clusters(errors: ReturnErrors) -> list[Step]:
    steps = []
    for name, runs in (("cw", errors.cw), ("ccw", errors.ccw)):
        for axis, label in enumerate("xy"):
            values = 1e3 * runs[:, axis]
            how = f"({' '.join(f'{value:+.1f}' for value in values)}) / {len(values)}"
            steps.append(Step("3.2", f"{label}_cg,{name}", how, float(values.mean()), "mm"))
    for name, centre in zip(("cw", "ccw"), 1e3 * errors.centres, strict=True):
        how = f"sqrt({centre[0]:.2f}^2 + {centre[1]:.2f}^2)"
        steps.append(Step("3.3", f"r_cg,{name}", how, math.hypot(centre[0], centre[1]), "mm"))
    radii = 1e3 * errors.radii
    steps.append(Step("3.4", "E_max,syst", f"max({radii[0]:.2f}, {radii[1]:.2f})", float(radii.max()), "mm"))
    return steps


def _angles(errors: ReturnErrors, x: Sequence[float], y: Sequence[float]) -> list[Step]:
    (cw_x, cw_y, _), (ccw_x, ccw_y, _) = 1e3 * errors.centres
    below = f"/ (-4 x {1e3 * errors.side:g}) x 180/pi"
    lines = (
        ("4.20a", "beta_x", f"({cw_x:.2f} - {ccw_x:.2f}) {below}", x[1]),
        ("4.20b", "beta_y", f"({cw_y:.2f} + {ccw_y:.2f}) {below}", y[1]),
        ("4.24a", "alpha_x", f"({cw_x:.2f} + {ccw_x:.2f}) {below}", x[0]),
        ("4.24b", "alpha_y", f"({cw_y:.2f} - {ccw_y:.2f}) {below}", y[0]),
    )
    return [Step(number, symbol, how, math.degrees(value), "deg") for number, symbol, how, value in lines]


def _factors(label: str, angles: Sequence[float], side: float, wheelbase: float) -> list[Step]:
    """Return R, E_d, b and E_b from alpha and beta [rad]; R is infinite for equal wheels."""
    alpha, beta = angles
    degrees = math.degrees(alpha)
    radius = math.inf if beta == 0.0 else 0.5e3 * side / math.sin(0.5 * beta)
    half = 0.5e3 * wheelbase
    ratio = 1.0 if math.isinf(radius) else (radius + half) / (radius - half)
    turns = f"90 / (90 - {degrees:.4f})".replace("- -", "+ ")
    base = 90.0 / (90.0 - degrees)
    bend = f"{500.0 * side:g} / sin({math.degrees(beta):.4f} deg / 2)"
    return [
        Step("4.21", f"R_{label}", bend, radius, "mm"),
        Step("4.22", f"E_d,{label}", f"(R + {half:g}) / (R - {half:g})", ratio),
        Step("4.26", f"b_{label}", f"{turns} x {1e3 * wheelbase:g}", 1e3 * base * wheelbase, "mm"),
        Step("4.27", f"E_b,{label}", turns, base),
    ]


def _means(by_x: list[Step], by_y: list[Step], truck: Truck) -> list[Step]:
    e_d, e_b = (0.5 * (by_x[row].value + by_y[row].value) for row in (1, 3))
    mean = 500.0 * (truck.wheel_diameter_left + truck.wheel_diameter_right)
    ratio = e_d * truck.wheel_diameter_right / truck.wheel_diameter_left
    left, right = 2.0 * mean / (ratio + 1.0), 2.0 * mean / (1.0 / ratio + 1.0)
    was = 1e3 * truck.wheel_diameter_left, 1e3 * truck.wheel_diameter_right
    steps = [
        Step("note 2", "E_d", f"({by_x[1].value:.6f} + {by_y[1].value:.6f}) / 2", e_d),
        Step("note 2", "E_b", f"({by_x[3].value:.6f} + {by_y[3].value:.6f}) / 2", e_b),
        Step("4.26", "b_actual", f"{e_b:.6f} x {1e3 * truck.wheelbase:g}", 1e3 * e_b * truck.wheelbase, "mm"),
        Step("4.28", "D_a", f"({was[1]:g} + {was[0]:g}) / 2", mean, "mm"),
    ]
    if was[0] != was[1]:
        steps.append(Step("2.3", "D_R/D_L", f"{e_d:.6f} x {was[1]:g} / {was[0]:g}", ratio))
    return [
        *steps,
        Step("4.29", "D_L", f"2 / ({ratio:.6f} + 1) x {mean:g}", left, "mm"),
        Step("4.30", "D_R", f"2 / (1 / {ratio:.6f} + 1) x {mean:g}", right, "mm"),
        Step("4.31", "c_L", f"{left:.6f} / {was[0]:g}", left / was[0]),
        Step("4.32", "c_R", f"{right:.6f} / {was[1]:g}", right / was[1]),
        Step("4.33", "U_L", f"{left / was[0]:.6f} x 1000, for 1000 mm of (2.2)", 1e3 * left / was[0], "mm"),
        Step("4.33", "U_R", f"{right / was[1]:.6f} x 1000, for 1000 mm of (2.2)", 1e3 * right / was[1], "mm"),
    ]
