"""A first look at an imported recording: where its nominal odometry ends, beside the last absolute pose.

Odometry that ends metres away, or on the other side, tells of swapped wheels, a wrong sign, a wrong unit or a
wrong resolution sooner than any calibration does.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vehicle.odometry import dead_reckon, truck_travel
from vehicle.se2 import between, wrap

if TYPE_CHECKING:
    from vehicle.parameters import TruckName
    from vehicle.recording import Recording


class Sanity(NamedTuple):
    """One truck's odometry with nominal parameters, from its first whole absolute pose to its last.

    Attributes:
        way: of the truck's middle, by its wheels [m].
        away: distance of where it ends from the pose [m].
        turned: difference of heading [rad], in (-pi, pi].
    """

    way: float
    away: float
    turned: float


def look(recording: Recording, truck: TruckName = "a") -> Sanity | None:
    """Return how far odometry is off at the end; None without two poses that have a heading."""
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
