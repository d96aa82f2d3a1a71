"""A first check of an imported recording: the end of its nominal odometry against the last absolute pose.

Odometry that ends metres away, or on the other side, shows swapped wheels, a wrong sign, a wrong unit or a
wrong resolution before any calibration does.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from omnimate.vehicle.odometry import dead_reckon, truck_travel
from omnimate.vehicle.se2 import between, wrap

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.vehicle.parameters import TruckName
    from omnimate.vehicle.recording import Recording


class Sanity(NamedTuple):
    """One truck's odometry with nominal parameters, from its first complete absolute pose to its last.

    Attributes:
        way: Length of the path of the axle's middle, by the wheels [m].
        away: Distance between the end of the odometry and the absolute pose [m].
        turned: Difference of their headings [rad], in (-pi, pi].
    """

    way: float
    away: float
    turned: float


def look(recording: Recording, truck: TruckName = "a") -> Sanity | None:
    """Return the error of odometry at the end; None without two poses that have a heading."""
    if recording.poses is None:
        return None
    fixes = recording.poses.of(truck)
    inside = (fixes.time >= recording.time[0]) & (fixes.time <= recording.time[-1])
    whole = np.flatnonzero(inside & np.isfinite(fixes.pose).all(axis=1))
    if len(whole) < 2:
        return None
    ends = whole[[0, -1]]
    first, last = np.searchsorted(recording.time, fixes.time[ends] - 1e-6)
    path = dead_reckon(recording, truck)
    missed = between(path[first], path[last]) - between(*fixes.pose[ends])
    left, right, _ = truck_travel(recording, truck)
    way = np.abs(np.diff(0.5 * (left + right)[first : last + 1])).sum()
    return Sanity(float(way), float(np.hypot(missed[0], missed[1])), float(wrap(missed[2])))


def average(results: Sequence[Sanity]) -> Sanity | None:
    """Return the mean way, and the root mean square of distances and headings; None where there are none."""
    if not results:
        return None
    count = len(results)
    away = math.sqrt(sum(result.away**2 for result in results) / count)
    turned = math.sqrt(sum(result.turned**2 for result in results) / count)
    return Sanity(sum(result.way for result in results) / count, away, turned)
