"""The size of a fault, measured from the true motion of a robot that has it, on a plane."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from studies.mismatch.engines.robots import WHEELS
from studies.mismatch.engines.true_motion import WINDOW, motion, residuals

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from studies.mismatch.engines.true_motion import Drive, Nominal

    Array = NDArray[np.float64]


def rolling_radius(drive: Drive, nominal: Nominal, wheel: str, rows: slice = slice(None)) -> float:
    """Return the radius on which a wheel rolled [m], in some of the windows of a drive."""
    column = WHEELS.index(wheel)
    turned = motion(drive, WINDOW)[1][rows, column]
    travelled = residuals(drive, nominal)[rows, column] + turned * nominal.radii[column]
    return float(travelled @ turned / (turned @ turned))


def before_and_after(time: float, drive: Drive) -> tuple[slice, slice]:
    """Return the windows of a drive that end before a time [s], and those that begin after it."""
    row = time / (drive.time[1] * WINDOW)
    return slice(int(row)), slice(int(np.ceil(row)), None)


def turning_base(drive: Drive, nominal: Nominal, truck: int) -> float:
    """Return the wheelbase on which a truck turned [m]."""
    moved, turned = motion(drive, WINDOW)
    left, right = (turned * nominal.radii)[:, 2 * truck : 2 * truck + 2].T
    yaw = moved[:, truck, 2]
    return float((right - left) @ yaw / (yaw @ yaw))


def travel_angle(drive: Drive, truck: int) -> float:
    """Return the angle of a truck's travel to its own straight ahead, where it does not turn [rad]."""
    forward, aside, yaw = motion(drive, WINDOW)[0][:, truck].T
    straight = np.abs(yaw) < np.quantile(np.abs(yaw), 0.5) + 1e-9
    return float(aside[straight] @ forward[straight] / (forward[straight] @ forward[straight]))


def wave(drive: Drive, nominal: Nominal, wheel: str) -> tuple[float, float]:
    """Return amplitude [m] and phase [rad] of a wheel's rolling radius over its angle."""
    column = WHEELS.index(wheel)
    turned = np.diff(drive.wheels[:, column])
    angle = drive.wheels[:-1, column] + 0.5 * turned
    columns = turned[:, None] * np.stack([np.cos(angle), -np.sin(angle), np.ones_like(angle)], axis=1)
    even, odd, _ = np.linalg.lstsq(columns, residuals(drive, nominal, 1)[:, column], rcond=None)[0]
    return float(np.hypot(even, odd)), float(np.arctan2(odd, even))


def lost(drive: Drive, nominal: Nominal, wheel: str, inside: NDArray[np.bool_]) -> float:
    """Return the share of the rolled way that a wheel lost in some rows; 0 where it did not roll."""
    column = WHEELS.index(wheel)
    rows = inside[1:]
    rolled = motion(drive)[1][rows, column] * nominal.radii[column]
    missed = -residuals(drive, nominal, 1)[rows, column] * np.sign(rolled)
    whole = float(np.abs(rolled).sum())
    return float(missed.sum()) / whole if whole else 0.0


def axle_ahead(drive: Drive) -> Array:
    """Return how far ahead of each truck's origin it turns without moving sideways [m], shape `(T,)`."""
    _, aside, yaw = np.moveaxis(motion(drive, WINDOW)[0], -1, 0)
    return np.asarray(-(aside * yaw).sum(axis=0) / np.maximum((yaw**2).sum(axis=0), 1e-12))
