"""Plausibility check of an imported recording: end of nominal odometry against the last absolute pose.

Odometry that ends metres away, or on the other side, shows swapped wheels, a wrong sign, a wrong unit or a
wrong resolution before any calibration does.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from omnimate.vehicle.odometry import dead_reckon, truck_travel
from omnimate.vehicle.se2 import between, wrap

if TYPE_CHECKING:
    from omnimate.vehicle.parameters import TruckName
    from omnimate.vehicle.recording import Recording


class OdometryError(NamedTuple):
    """One truck's odometry with nominal parameters, from its first complete absolute pose to its last.

    The length of the path of the axle's middle by the wheels [m], and from the end of the odometry to the
    absolute pose the distance [m] and the difference of headings [rad], in (-pi, pi].
    """

    distance: float
    position: float
    heading: float


def odometry_error(recording: Recording, truck: TruckName = "a") -> OdometryError | None:
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
    distance = np.abs(np.diff(0.5 * (left + right)[first : last + 1])).sum()
    return OdometryError(float(distance), float(np.hypot(missed[0], missed[1])), float(wrap(missed[2])))
