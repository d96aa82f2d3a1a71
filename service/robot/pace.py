"""The pace of a simulated robot: real time while it is looked at, faster while it drives a session."""

from __future__ import annotations

import time

from driver.clock import SyncClock

BEHIND = 0.5  # [s] of host time that are not caught up with in a burst


class PacedClock(SyncClock):
    """SYNC k has the time start + k * period; host time passes at `pace` times that.

    Attributes:
        skipped: always 0; a simulated bus waits for its master.
    """

    def __init__(self, period: float, start: float) -> None:
        super().__init__(period, start)
        self.skipped = 0
        self._pace = 1.0
        self._anchor()

    def _anchor(self) -> None:
        self._from, self._since = self._next, time.monotonic()

    @property
    def pace(self) -> float:
        """Seconds of the robot's in one of the host's."""
        return self._pace

    @pace.setter
    def pace(self, pace: float) -> None:
        self._pace = pace
        self._anchor()

    def due(self) -> float:
        """Return how long to wait before the next SYNC [s]."""
        wait = self._since + (self._next - self._from) * self.period / self._pace - time.monotonic()
        if wait < -BEHIND:
            self._anchor()
        return wait
