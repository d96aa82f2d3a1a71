"""When a frame was on the bus, by the time stamps of the adapter: a host that reads late does not matter."""

from __future__ import annotations

import math

LEARNING = 1.0  # [s] after which stamps are believed that have gone on like the host's time
LATEST = 0.5  # [s] by which a frame may be read late; a clock that differs more has jumped or stands
WINDOW = 2.0  # [s], in which clocks of two quartzes, 100 ppm apart, differ by 0.2 ms


class AdapterTime:
    """The host's time at which frames were on the bus.

    The smallest time between a stamp and its reading in the last seconds is the difference of the two clocks.
    Stamps that stand, jump, wrap or are missing are not believed, and the time of reading counts.
    """

    def __init__(self) -> None:
        self._since = math.inf  # beginning of what is known of the stamps
        self._turned = 0.0  # beginning of the present window
        self._least = self._before = math.inf  # smallest difference in the present and the former window

    def heard(self, stamp: float, now: float) -> float:
        """Return the host's time at which a frame was on the bus [s].

        Args:
            stamp: Stamp of the adapter [s], on any clock; 0 for none.
            now: Host's time at which the frame is read [s].
        """
        difference = now - stamp
        floor = min(self._least, self._before)
        if not (stamp > 0.0 and abs(difference - floor) < LATEST):
            is_stamp = stamp > 0.0 and math.isfinite(stamp)
            self._since, self._turned = (now, now) if is_stamp else (math.inf, 0.0)
            self._least, self._before = difference if is_stamp else math.inf, math.inf
            return now
        if now - self._turned >= WINDOW:
            self._turned, self._before, self._least = now, self._least, difference
        self._least = min(self._least, difference)
        if now - self._since < LEARNING:
            return now
        return min(now, stamp + min(self._least, self._before))
