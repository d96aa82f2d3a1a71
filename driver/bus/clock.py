"""Clocks that pace SYNC: by wall time, or as fast as the vehicle answers."""

from __future__ import annotations

import math
import time

FRAME_STEP = 1e-6  # [s] between two frames of `SyncClock`: the last digit of a candump log
ANSWER_WINDOW = 0.5  # [s] of host time for the answers to one SYNC of `SyncClock`
# Of `AdapterTime`:
LEARNING_TIME = 1.0  # [s] for which stamps must follow the host's time before they are used
MAX_DELAY = 0.5  # [s] by which a frame may be read late; a clock that differs more has jumped or stopped
WINDOW = 2.0  # [s], in which clocks of two quartzes, 100 ppm apart, differ by 0.2 ms


class AdapterTime:
    """The host's time at which frames were on the bus.

    The smallest time between a stamp and its reading in the last seconds is the difference of the two clocks.
    Where stamps stop, jump, wrap or are missing, the time of reading counts.
    """

    def __init__(self) -> None:
        self._since = math.inf  # time of the first usable stamp
        self._window_start = 0.0
        self._least = self._previous_least = math.inf  # differences, in the current and the previous window

    def host_time(self, stamp: float, now: float) -> float:
        """Return the host's time at which a frame was on the bus [s].

        Args:
            stamp: Stamp of the adapter [s], on any clock; 0 for none.
            now: Host's time at which the frame is read [s].
        """
        difference = now - stamp
        floor = min(self._least, self._previous_least)
        if not (stamp > 0.0 and abs(difference - floor) < MAX_DELAY):
            is_stamp = stamp > 0.0 and math.isfinite(stamp)
            self._since, self._window_start = (now, now) if is_stamp else (math.inf, 0.0)
            self._least, self._previous_least = difference if is_stamp else math.inf, math.inf
            return now
        if now - self._window_start >= WINDOW:
            self._window_start, self._previous_least, self._least = now, self._least, difference
        self._least = min(self._least, difference)
        if now - self._since < LEARNING_TIME:
            return now
        return min(now, stamp + min(self._least, self._previous_least))


class WallClock:
    """SYNC at equal intervals of monotonic time; times are wall time that no clock adjustment moves.

    The `period` between two SYNCs is in [s]; `skipped` counts periods that have passed without a SYNC.
    """

    inline = False  # an SDO dialogue runs in a thread, while SYNC goes on

    def __init__(self, period: float) -> None:
        self.period = period
        self.skipped = 0
        self._offset = time.time() - time.monotonic()
        self._adapter = AdapterTime()
        self._deadline: float | None = None

    def due(self) -> float:
        """Return how long to wait before the next SYNC [s]."""
        return 0.0 if self._deadline is None else self._deadline - time.monotonic()

    def sync(self) -> float:
        """Note a SYNC; periods that have passed already are skipped and counted, not sent in a burst."""
        now = time.monotonic()
        deadline = (now if self._deadline is None else self._deadline) + self.period
        behind = max(0, int((now - deadline) / self.period) + 1) if now >= deadline else 0
        self.skipped += behind
        self._deadline = deadline + behind * self.period
        return now + self._offset

    def remaining(self) -> float:
        """Return the time left until the next SYNC [s]."""
        return self.due()

    def now(self) -> float:
        """Return wall time [s]."""
        return time.monotonic() + self._offset

    def sleep(self, seconds: float) -> None:
        """Let time pass [s], such as before a lost bus is opened again."""
        time.sleep(seconds)

    def frame_time(self, stamp: float) -> float:
        """Return the wall time at which a frame was on the bus [s], by the adapter's stamps where it can."""
        return self._adapter.host_time(stamp, time.monotonic()) + self._offset


class SyncClock:
    """SYNC k has the time start + k * period [s], however long it took; nothing waits for it.

    Frames in between follow the SYNC one after the other, `FRAME_STEP` apart, so that no time is the host's.

    Args:
        period: Time between two SYNCs [s].
        start: Time of SYNC 0 [s]; now where it is None.
    """

    inline = True  # time stops between SYNCs, so that an SDO dialogue may run in between
    skipped = 0  # SYNCs that were left out: the bus waits for its master

    def __init__(self, period: float, start: float | None = None) -> None:
        self.period = period
        self.start = time.time() if start is None else start
        self._next = 0
        self._frames = 0  # since the last SYNC
        self._sent = time.monotonic()

    def due(self) -> float:
        """Return 0: the next SYNC is always due."""
        return 0.0

    def sync(self) -> float:
        """Note a SYNC and return start + k * period [s]."""
        self._next += 1
        self._frames = 0
        self._sent = time.monotonic()
        return self.start + (self._next - 1) * self.period

    def remaining(self) -> float:
        """Return how much of `ANSWER_WINDOW` is left [s]."""
        return self._sent + ANSWER_WINDOW - time.monotonic()

    def now(self) -> float:
        """Return the time of the last frame or SYNC [s]."""
        passed = min(self._frames * FRAME_STEP, 0.9 * self.period)
        return self.start + (self._next - 1) * self.period + passed

    def frame_time(self, stamp: float) -> float:
        """Return the time of the next frame after SYNC [s], whatever its stamp."""
        del stamp
        self._frames += 1
        return self.now()

    def sleep(self, seconds: float) -> None:
        """Let host time pass [s]."""
        time.sleep(seconds)


Clock = WallClock | SyncClock
