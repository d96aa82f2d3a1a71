"""Poses as a measuring system reports them: of its reference point, and with latency or clock drift."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

import numpy as np

from omnimate.effects.ageing import AgedSamples
from omnimate.effects.effect import TRUCK
from omnimate.effects.reference_offset import ReferenceOffset

if TYPE_CHECKING:
    from collections.abc import Iterable

    from omnimate.effects.effect import Effect
    from omnimate.vehicle.se2 import Array


class AgedPoses:
    """The true poses of all trucks, from the oldest that may still be reported to the latest.

    Args:
        effects: Effects on the measured poses.
        start_time: Time at the start of the drive [s].
    """

    def __init__(self, effects: Iterable[Effect], start_time: float) -> None:
        effects = tuple(effects)
        self._effects = [effect for effect in effects if isinstance(effect, AgedSamples)]
        self._offsets = [effect for effect in effects if isinstance(effect, ReferenceOffset)]
        self._start = start_time
        self._past: deque[tuple[float, Array]] = deque()

    def add(self, time: float, poses: Array) -> None:
        """Add the true poses `(T, 3)` at a time [s], and remove those too old to be reported."""
        self._past.append((time, poses.copy()))
        oldest = time - self._age(time) if self._effects else time
        while len(self._past) > 2 and self._past[1][0] <= oldest:
            self._past.popleft()

    def reported(self, truck: int) -> Array:
        """Return the pose `(3,)` of a truck's reference point that is reported at the time added last."""
        pose = self._delayed(truck)
        for effect in self._offsets:
            if TRUCK.index(effect.component) == truck:
                pose = effect.measured(pose)
        return pose

    def _delayed(self, truck: int) -> Array:
        """Return the delayed pose `(3,)` of a truck."""
        now, poses = self._past[-1]
        if not self._effects:
            return np.array(poses[truck])
        time = np.array([time for time, _ in self._past])
        values = np.stack([poses[truck] for _, poses in self._past])
        age = self._age(now)
        if age < 0.0 and len(time) > 1:  # extrapolated along the last step
            return np.asarray(values[-1] - age * (values[-1] - values[-2]) / (time[-1] - time[-2]))
        return np.array([np.interp(now - age, time, axis) for axis in values.T])

    def _age(self, now: float) -> float:
        return sum(float(effect.age(np.array([now]), self._start)[0]) for effect in self._effects)
