"""The clock of a simulated robot: real time while it stands, faster while it drives a session."""

from __future__ import annotations

import time

from omnimate.driver.bus.clock import SyncClock

LARGEST_DELAY = 0.5  # [s] of host time; a longer delay is not caught up with


class PacedClock(SyncClock):
    """SYNC number k has the time start + k * period, and comes when the host's time has passed `pace` times.

    Attributes:
        skipped: The number of SYNCs that were left out, always 0: a simulated bus waits for its master.
    """

    def __init__(self, period: float, start: float) -> None:
        super().__init__(period, start)
        self.skipped = 0
        self._pace = 1.0
        self._anchor()

    def _anchor(self) -> None:
        """Count the host's time from here on."""
        self._anchor_sync, self._anchor_time = self._next, time.monotonic()

    @property
    def pace(self) -> float:
        """How many times faster than the host's time the robot's time passes."""
        return self._pace

    @pace.setter
    def pace(self, pace: float) -> None:
        self._pace = pace
        self._anchor()

    def due(self) -> float:
        """Return the time until the next SYNC [s]; it is negative when the SYNC is late."""
        host_time = (self._next - self._anchor_sync) * self.period / self._pace
        wait = self._anchor_time + host_time - time.monotonic()
        if wait < -LARGEST_DELAY:
            self._anchor()
        return wait
