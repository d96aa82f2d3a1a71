"""UMBmark as printed: from two centres of gravity to E_b and E_d by small-angle formulas, U (4.17)-(4.32).

The paper gives angles in degrees; here they are radians throughout, as (4.21) needs them. alpha > 0: every
corner turns less than 90 degrees. beta > 0: every leg curves to the left.

The paper computes E_d before it corrects the wheelbase, hence with the nominal b in (4.22), and all of its
figures agree with that. The curve of a leg follows from the actual b; "printed-true-b" uses that.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from omnimate.calib.errors import CalibrationError

if TYPE_CHECKING:
    from omnimate.calib.umbmark.return_errors import ReturnErrors
    from omnimate.vehicle.se2 import Array

Method = Literal["printed-x", "printed-y", "printed", "printed-true-b", "heading", "exact", "weighted"]


@dataclass(frozen=True, slots=True)
class Correction:
    """The correction of a truck by a UMBmark experiment."""

    method: Method  # method that gave the correction
    alpha: float  # angle by which each corner turns too little [rad], type A error
    beta: float  # angle by which the heading turns along each leg [rad], type B error
    e_b: float  # actual over nominal wheelbase, U (2.4)
    e_d: float  # actual over nominal ratio of right to left wheel diameter, U (2.3)


def printed_angles(centres: Array, side: float) -> Array:
    """Return `(..., 2, 2)` alpha, beta [rad] from the x and from the y of centres `(..., 2, 3)`, cw then ccw.

    U (4.24a) and (4.20a), then (4.24b) and (4.20b).
    """
    (cw_x, ccw_x), (cw_y, ccw_y) = (np.moveaxis(centres[..., axis], -1, 0) for axis in (0, 1))
    from_x, from_y = (cw_x + ccw_x, cw_x - ccw_x), (cw_y - ccw_y, cw_y + ccw_y)
    return np.stack([np.stack(from_x, axis=-1), np.stack(from_y, axis=-1)], axis=-2) / (-4.0 * side)


def heading_angles(centres: Array) -> Array:
    """Return `(..., 1, 2)` alpha, beta [rad] from the headings of centres `(..., 2, 3)`, cw then ccw.

    Source: Jung & Chung, Int J Adv Robot Syst 9 (2012), without their coupling term.
    """
    cw, ccw = centres[..., 0, 2], centres[..., 1, 2]
    return np.stack([cw - ccw, cw + ccw], axis=-1)[..., None, :] / 8.0


def wheelbase_factor(alpha: Array | float) -> Array:
    """Return E_b for alpha [rad], U (4.27)."""
    return np.asarray(0.5 * math.pi / (0.5 * math.pi - alpha))


def diameter_ratio(beta: Array | float, side: float, wheelbase: Array | float) -> Array:
    """Return E_d for beta [rad] on legs of `side` [m], U (4.21) and (4.22) without the infinite radius."""
    half = wheelbase * np.sin(0.5 * beta) / side  # b / (2 R)
    return np.asarray((1.0 + half) / (1.0 - half))


def angles_of(centres: Array, side: float, method: Method) -> Array:
    """Return the pairs `(..., m, 2)` of alpha, beta [rad] that a method of small angles averages over."""
    if method == "heading":
        return heading_angles(centres)
    angles = printed_angles(centres, side)
    kept = {"printed-x": slice(0, 1), "printed-y": slice(1, 2)}.get(method, slice(0, 2))
    return angles[..., kept, :]


def factors_of(angles: Array, side: float, wheelbase: float, method: Method) -> Array:
    """Return `(..., 2)` E_b, E_d of pairs of angles `(..., m, 2)` [rad]; factors are averaged, footnote 2.

    The nominal b is used in (4.22), as in the paper; "printed-true-b" and "heading" use the corrected b, and
    "heading" treats each leg as an arc.
    """
    alpha, beta = angles[..., 0], angles[..., 1]
    e_b = wheelbase_factor(alpha)
    if method == "heading":
        half = 0.5 * wheelbase * e_b * beta / side
        e_d = (1.0 + half) / (1.0 - half)
    else:
        e_d = diameter_ratio(beta, side, wheelbase * e_b if method == "printed-true-b" else wheelbase)
    return np.stack([e_b.mean(axis=-1), e_d.mean(axis=-1)], axis=-1)


def solve_printed(errors: ReturnErrors, wheelbase: float, method: Method = "printed") -> Correction:
    """Return the correction by the paper's equations, or from the return headings alone.

    "printed-x" uses x alone, "printed-y" y alone; "printed" averages both as in footnote 2, with the nominal
    wheelbase b [m] in (4.22); "printed-true-b" averages too and takes the corrected b; "heading" uses neither
    x nor y.

    Raises:
        CalibrationError: The errors are too large for small angles, or a heading is missing.
    """
    if method == "heading" and not errors.has_headings:
        raise CalibrationError(errors.source, "headings are wanted, but some run has none")
    angles = angles_of(errors.centres, errors.side, method)
    if (np.abs(angles) >= 0.25 * math.pi).any():
        raise CalibrationError(
            errors.source,
            f"return errors of {1e3 * errors.e_max_syst:.0f} mm on a square of {errors.side:g} m mean more "
            "than 45 degrees at a corner; check the units and the side (one leg, not the whole path)",
        )
    e_b, e_d = factors_of(angles, errors.side, wheelbase, method)
    alpha, beta = angles.mean(axis=0)
    return Correction(method, float(alpha), float(beta), float(e_b), float(e_d))
