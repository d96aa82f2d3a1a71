"""Intervals of shares that were counted."""

from __future__ import annotations

import math

_Z = 1.96  # the normal distribution's quantile of 97.5 %


def wilson(hits: int, of: int) -> tuple[float, float]:
    """Return the 95 % interval of a share, Wilson (1927); nan without any case."""
    if not of:
        return math.nan, math.nan
    share, square = hits / of, _Z * _Z
    middle, width = (
        share + square / (2 * of),
        _Z * math.sqrt(share * (1 - share) / of + square / (4 * of * of)),
    )
    return (middle - width) / (1 + square / of), (middle + width) / (1 + square / of)
