"""Absolute poses of one truck, put together from columns."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omnimate.vehicle.recording import Poses
from omnimate.vehicle.se2 import wrap

if TYPE_CHECKING:
    from collections.abc import Iterable

    from omnimate.vehicle.parameters import TruckName
    from omnimate.vehicle.se2 import Array


def poses_of(truck: TruckName, time: Array, pose: Array, sigma: Array | None = None) -> Poses:
    """Return the absolute poses of a truck; rows without a known component are left out.

    Args:
        truck: Name of the truck, a or b.
        time: Time of each pose [s], shape `(M,)`.
        pose: x, y [m] and theta [rad], not necessarily wrapped, shape `(M, 3)`; nan where unknown.
        sigma: Standard deviations of the poses, shape `(M, 3)`; None where they are not stated.
    """
    known = np.isfinite(pose).any(axis=1)
    stated = np.full(pose.shape, np.nan) if sigma is None else sigma
    kept = pose[known].copy()
    kept[:, 2] = wrap(kept[:, 2])
    return Poses(time[known].copy(), np.full(int(known.sum()), truck, "U1"), kept, stated[known].copy())


def joined(parts: Iterable[Poses]) -> Poses | None:
    """Return the poses of several trucks in order of time; None where there are none."""
    parts = [part for part in parts if len(part.time)]
    if not parts:
        return None
    time = np.concatenate([part.time for part in parts])
    order = np.argsort(time, kind="stable")
    body, pose, sigma = (
        np.concatenate([getattr(part, name) for part in parts])[order] for name in ("body", "pose", "sigma")
    )
    return Poses(time[order], body, pose, sigma)
