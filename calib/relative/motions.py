"""Relative poses of a sensor from scan matching, and a check of the kinds of motion."""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.calib.errors import CalibrationError
from omnimate.vehicle.errors import describe_read_error

if TYPE_CHECKING:
    from pathlib import Path

    from omnimate.vehicle.se2 import Array

COLUMNS = ("start", "end", "x", "y", "theta", "sigma_x", "sigma_y", "sigma_theta")
# [1] squared travel along one ratio of the wheels, over all: above it there is one kind of motion
_SINGLE_KIND_SHARE = 0.99
_KIND_TOLERANCE = 0.05  # [rad] in the plane of both wheels' travel: radii above ten wheelbases are straight
_MIN_TRAVEL = 0.1  # [m] of a wheel's travel below which the robot stands


@dataclass(frozen=True, slots=True)
class Motions:
    """Relative poses of a sensor."""

    source: str  # file or recording that they come from
    start: Array  # time of the first scan of each [s], on the recording's clock, `(K,)`
    end: Array  # time of the second one [s], `(K,)`
    pose: Array  # sensor at the second scan, seen from the first: x, y [m], theta [rad], `(K, 3)`
    sigma: Array  # standard deviations, in the frame of the second scan [m, m, rad], `(K, 3)`


def load_motions(path: Path) -> Motions:
    """Return the relative poses of a CSV file with the columns `COLUMNS`.

    Raises:
        CalibrationError: The file cannot be read, or has other columns, or a line is no motion.
    """
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            reader = csv.DictReader(file)
            missing = [name for name in COLUMNS if name not in (reader.fieldnames or ())]
            if missing:
                wanted = ", ".join(COLUMNS)
                raise CalibrationError(path, f"no column {', '.join(missing)}; expected {wanted}")
            rows = [_row(path, reader.line_num, line) for line in reader]
    except (OSError, UnicodeDecodeError) as error:
        raise CalibrationError(path, f"cannot be read: {describe_read_error(error)}") from error
    except csv.Error as error:
        raise CalibrationError(path, f"cannot be read: {error}") from error
    if not rows:
        raise CalibrationError(path, "no relative pose in it")
    table = np.array(rows)
    return Motions(str(path), table[:, 0], table[:, 1], table[:, 2:5], table[:, 5:8])


def _row(path: Path, number: int, line: dict[str, str]) -> list[float]:
    try:
        row = [float(line[name]) for name in COLUMNS]
    except (TypeError, ValueError) as error:
        raise CalibrationError(path, f"line {number}: expected numbers: {error}") from error
    if not all(map(math.isfinite, row)) or row[1] <= row[0] or min(row[5:]) <= 0.0:
        raise CalibrationError(
            path, f"line {number}: expected finite numbers, end after start, sigmas above 0"
        )
    return row


def missing_motion(travel: Array, wheelbase: float) -> str | None:
    """Return the only kind of motion and which to add; None if there are several kinds.

    One kind of motion does not identify all parameters (Censi et al. 2013, section IV). `travel` `(K, 2)` is
    that of the left and the right wheel in each motion [m].
    """
    squares = travel.T @ travel
    if np.abs(travel).sum(axis=0).max() < _MIN_TRAVEL:
        return "the robot stands still: drive arcs of several radii"
    values, vectors = np.linalg.eigh(squares)
    if values[1] < _SINGLE_KIND_SHARE * values.sum():
        return None
    angle = math.atan2(vectors[1, 1], vectors[0, 1])
    if _apart(angle, math.pi / 4.0) < _KIND_TOLERANCE:
        return "straight ways only: drive curves, or turn on the spot"
    if _apart(angle, -math.pi / 4.0) < _KIND_TOLERANCE:
        return "turning on the spot only: drive straight ways or curves, too"
    ahead, turn = math.cos(angle) + math.sin(angle), math.sin(angle) - math.cos(angle)
    radius = abs(0.5 * wheelbase * ahead / turn)
    side = "left" if turn * ahead > 0.0 else "right"
    return f"one arc only, of {radius:.2f} m to the {side}: drive arcs of other radii, or turn on the spot"


def _apart(angle: float, other: float) -> float:
    """Return the angle between two lines [rad]."""
    return abs(math.remainder(angle - other, math.pi))
