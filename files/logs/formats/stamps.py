"""Times as whole nanoseconds, as other tools' files have them."""

from __future__ import annotations

import math

NANOSECOND = 1_000_000_000


def nanoseconds(time: float) -> int:
    """Return a time [s] as whole nanoseconds, from which `seconds` gives the same time again.

    A double of these years has steps of 240 ns: where it is what a log with microseconds says, the result
    ends in three zeros as the log does, and does not show digits that nobody measured.
    """
    micros = round(time * 1e6)
    if micros / 1e6 == time:
        return micros * 1000
    whole = math.floor(time)
    return whole * NANOSECOND + round((time - whole) * NANOSECOND)


def seconds(stamp: int) -> float:
    """Return whole nanoseconds as a time [s]."""
    return stamp / NANOSECOND
