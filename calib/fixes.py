"""Fixes (absolute poses measured at rest) and the travel of the wheels between them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omnimate.calib.errors import FixError
from omnimate.vehicle.odometry import truck_travel
from omnimate.vehicle.se2 import Array, wrap

if TYPE_CHECKING:
    from omnimate.vehicle.parameters import TruckName
    from omnimate.vehicle.recording import Poses, Recording

_REST_TIME = 0.1  # [s] before and after a fix at rest in which no wheel moves (assumption)
_REST_TRAVEL = 0.5e-3  # [m] largest travel of a wheel at rest: a few counts (assumption)


class WheelsAndFixes:
    """The wheels' travel and the fixes of one truck, on the recording's clock.

    `travel` is that of the left and the right wheel [m], `(N, 2)`, at each `time` [s], `(N,)`; `fixes` are
    the absolute poses with a known position.
    """

    def __init__(self, recording: Recording, truck: TruckName, fixes: Poses) -> None:
        left, right, _ = truck_travel(recording, truck)
        self.time, self.travel = recording.time, np.stack([left, right], axis=-1)
        known = np.isfinite(fixes.pose[:, :2]).all(axis=1)
        self.fixes = fixes.select(known)

    def rests(self) -> list[float]:
        """Return the time [s] of the first fix of every rest, in order."""
        times: list[float] = []
        before, after = (self._travel_at(self.fixes.time + shift) for shift in (-_REST_TIME, _REST_TIME))
        still = (np.abs(after - before) <= _REST_TRAVEL).all(axis=-1)
        for time in self.fixes.time[still]:
            if not times or time > self.rest(times[-1])[1]:
                times.append(float(time))
        return times

    def _travel_at(self, time: float | Array) -> Array:
        """Return the travel `(..., 2)` of both wheels at times [m]."""
        return np.stack([np.interp(time, self.time, wheel) for wheel in self.travel.T], axis=-1)

    def rest(self, time: float) -> tuple[float, float]:
        """Return start and end [s] of the rest around `time`, in which neither wheel moved."""
        moved = self.time[(np.abs(self.travel - self._travel_at(time)) > _REST_TRAVEL).any(axis=1)]
        earlier, later = moved[moved < time], moved[moved > time]
        return (
            float(earlier[-1]) if len(earlier) else -np.inf,
            float(later[0]) if len(later) else np.inf,
        )

    def fix_before(self, time: float, source: str) -> tuple[float, Array]:
        """Return time [s] and pose `(3,)` of the last fix at rest before a lap.

        Raises:
            FixError: There is no such fix, or it has no heading.
        """
        times = self.fixes.time[self.fixes.time < self.rest(time)[1]]
        if len(times) == 0:
            raise FixError(source, "no absolute pose before the lap; measure one at rest before it starts")
        pose = self.mean_fix(float(times[-1]))
        if np.isnan(pose[2]):
            raise FixError(
                source, "the absolute pose before the lap has no theta; return errors need its frame"
            )
        return float(times[-1]), pose

    def fix_after(self, time: float, source: str) -> tuple[float, Array]:
        """Return time [s] and pose `(3,)` of the first fix at rest after a lap; its theta may be nan.

        Raises:
            FixError: There is no such fix.
        """
        times = self.fixes.time[self.fixes.time > self.rest(time)[0]]
        if len(times) == 0:
            raise FixError(source, "no absolute pose after the lap; measure one at rest after it ends")
        return float(times[0]), self.mean_fix(float(times[0]))

    def mean_fix(self, time: float) -> Array:
        """Return the mean pose `(3,)` of all fixes in the rest around `time`."""
        start, end = self.rest(time)
        same = ((self.fixes.time > start) & (self.fixes.time < end)) | (self.fixes.time == time)
        return mean_pose(self.fixes.pose[same], self.fixes.sigma[same])

    def steps(self, start: float, end: float) -> Array:
        """Return the wheels' travel `(N, 2)` in each step between two times [m]."""
        inside = (self.time > start) & (self.time < end)
        travel = np.vstack([self._travel_at(start), self.travel[inside], self._travel_at(end)])
        return np.asarray(np.diff(travel, axis=0), np.float64)


def mean_pose(poses: Array, sigma: Array) -> Array:
    """Return the mean `(3,)` of poses `(M, 3)` by inverse variance, or equally where a sigma is unknown."""
    reference = np.nan_to_num(poses[0])
    offset = poses - reference
    offset[:, 2] = wrap(offset[:, 2])
    known = np.isfinite(offset)
    usable = np.isfinite(sigma) & (sigma > 0.0)
    weights = np.where((usable | ~known).all(axis=0), 1.0 / np.where(usable, sigma, 1.0) ** 2, 1.0) * known
    total = weights.sum(axis=0)
    mean = (weights * np.nan_to_num(offset)).sum(axis=0) / np.where(total > 0.0, total, 1.0)
    return np.where(total > 0.0, reference + mean, np.nan)
