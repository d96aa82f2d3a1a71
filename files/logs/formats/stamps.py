"""Conversion of times to whole nanoseconds."""

from __future__ import annotations

import math

NANOSECOND = 1_000_000_000


def nanoseconds(time: float) -> int:
    """Return a time [s] as whole nanoseconds, which divided by 1e9 are the same time again.

    A double has steps of 240 ns for present dates. If it equals a whole number of microseconds, as in a
    candump log, the result ends in three zeros, without digits that were not measured.
    """
    micros = round(time * 1e6)
    if micros / 1e6 == time:
        return micros * 1000
    whole = math.floor(time)
    return whole * NANOSECOND + round((time - whole) * NANOSECOND)
