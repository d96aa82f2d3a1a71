"""Units of logged data, and their conversion to seconds, metres, radians and raw counts."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from omnimate.files.errors import SourceError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from omnimate.files.importers.series import Series
    from omnimate.vehicle.parameters import Encoder, VehicleParameters
    from omnimate.vehicle.se2 import Array

SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
METRES = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
RADIANS = {"rad": 1.0, "deg": math.pi / 180.0, "turns": 2.0 * math.pi}
SPEEDS = ("rad/s", "m/s")
UNITS = ("counts", *RADIANS, *METRES, *SPEEDS)

_MAX_COUNT = 2**62  # largest count: half of a 64-bit counter's range


def counts_of(series: Series, vehicle: VehicleParameters, encoder: Encoder) -> NDArray[np.int64]:
    """Return the raw counts `(K,)` of an encoder for a series; 0 where nothing was measured.

    An angle or a length becomes the nearest count; a speed is first summed over time by the trapezoid rule.

    Raises:
        SourceError: The unit does not fit the channel, or the values are not possible counts.
    """
    raw = _raw(series, vehicle, encoder)
    known = np.isfinite(raw)
    wild = np.flatnonzero(known & (np.abs(raw) > _MAX_COUNT))
    if len(wild):
        raise SourceError(
            series.source,
            f"{series.value[wild[0]]:g} {series.unit} at {series.time[wild[0]]:.6f} s is too much",
        )
    if series.unit == "counts":
        broken = np.flatnonzero(known & (raw != np.rint(raw)))
        if len(broken):
            raise SourceError(
                series.source,
                f"{raw[broken[0]]:g} counts at {series.time[broken[0]]:.6f} s; expected whole numbers, or "
                f"another unit: {', '.join(UNITS[1:])}",
            )
    return np.rint(np.where(known, raw, 0.0)).astype(np.int64)


def _raw(series: Series, vehicle: VehicleParameters, encoder: Encoder) -> Array:
    """Return the counts before rounding `(K,)`."""
    if series.unit == "counts":
        return series.value
    if encoder.channel == "link":
        assert vehicle.linkage is not None  # a link has one
        length = series.value * _factor(series, METRES, encoder)
        return (length - vehicle.linkage.length) / encoder.scale + encoder.zero
    if encoder.channel in {"joint_a", "joint_b"}:
        return series.value * _factor(series, RADIANS, encoder) / encoder.scale + encoder.zero
    return _wheel_angle(series, vehicle, encoder) / encoder.scale


def _wheel_angle(series: Series, vehicle: VehicleParameters, encoder: Encoder) -> Array:
    """Return the angle `(K,)` of a wheel [rad]."""
    radius = 0.5 * vehicle.wheel_diameter(encoder.channel)
    if series.unit in SPEEDS:
        speed = series.value / (radius if series.unit == "m/s" else 1.0)
        if not np.isfinite(speed).all():
            at = series.time[~np.isfinite(speed)][0]
            raise SourceError(
                series.source, f"no speed at {at:.6f} s; speeds are summed, so none may be missing"
            )
        steps = 0.5 * (speed[1:] + speed[:-1]) * np.diff(series.time)
        return np.concatenate(([0.0], np.cumsum(steps)))
    if series.unit in METRES:
        return series.value * METRES[series.unit] / radius
    return series.value * _factor(series, RADIANS, encoder)


def _factor(series: Series, factors: dict[str, float], encoder: Encoder) -> float:
    if series.unit not in factors:
        raise SourceError(
            series.source,
            f"unit {series.unit!r} is none of {encoder.channel}; expected counts, {', '.join(factors)}",
        )
    return factors[series.unit]
