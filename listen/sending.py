"""Trigger of a message: SYNC, a timer, or a change of its data, by the shortest description."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from omnimate.listen.code_lengths import first_value, residual_code

if TYPE_CHECKING:
    from numpy.typing import NDArray

Cause = Literal["SYNC", "timer", "change", "cannot tell"]
TICK = 2.0**-17  # [s], 7.6 us: the shortest frame at 1 Mbit/s takes 47 bits
EXCEPTION_BITS = 10.0  # [bits] prior of 1 in 1000: a frame that a timer omits, or that repeats unchanged data
MIN_FRAMES = 8  # frames needed to distinguish the causes (assumption)


@dataclass(frozen=True, slots=True)
class Sending:
    """Trigger and timing of a message.

    Attributes:
        cause: Trigger of the message.
        probability: Probability of this cause [0 to 1].
        period: Median of its intervals [s]; 0 for a single frame.
        jitter: Standard deviation of the delay after SYNC if that is the cause, otherwise of the intervals
            within half of the median [s].
        every: SYNCs from one frame to the next (the transmission type) if SYNC is the cause; otherwise 0.
        delay: Median delay after SYNC if that is the cause; otherwise 0 [s].
    """

    cause: Cause
    probability: float
    period: float
    jitter: float
    every: int = 0
    delay: float = 0.0


def find_sending(
    time: NDArray[np.float64], data: NDArray[np.uint8], syncs: NDArray[np.float64], sync_period: float | None
) -> Sending:
    """Return the trigger and timing of a message.

    The code lengths of its times under three models are compared: the delay after SYNC, and the number of
    SYNCs from frame to frame; equal intervals of a timer; intervals of a device that sends only changed data,
    and so pauses and repeats no data.

    Args:
        time: Times of its frames [s], shape `(N,)`.
        data: Their data, shape `(N, length)`.
        syncs: Times of the SYNCs [s], shape `(M,)`.
        sync_period: Period of SYNC [s]; None without.
    """
    interval = np.diff(time)
    if len(interval) + 1 < MIN_FRAMES:
        period = float(np.median(interval)) if len(interval) else 0.0
        return Sending("cannot tell", 0.0, period, 0.0)
    median_interval = float(np.median(interval))
    regular = interval[np.abs(interval - median_interval) < 0.5 * median_interval]
    jitter = float(np.std(regular)) if len(regular) else 0.0
    grid = np.maximum(np.rint(interval / median_interval), 1.0)
    gaps = int(np.count_nonzero(grid > 1))
    same = int(np.count_nonzero(~np.any(data[1:] != data[:-1], axis=1)))
    # The code of a timer includes its period, that of SYNC only a small whole number.
    late = _ticks(interval - grid * median_interval) + first_value(round(median_interval / TICK), 32)
    lengths: dict[Cause, float] = {
        "timer": late + gaps * EXCEPTION_BITS,
        "change": late + gaps + same * EXCEPTION_BITS + 1.0,
    }
    without_sync = by_sync = (jitter, 0, 0.0)
    if sync_period and len(syncs) > MIN_FRAMES:
        number = np.searchsorted(syncs, time, "right") - 1
        after = number >= 0
        delay = time[after] - syncs[number[after]]
        between = np.diff(number[after])
        every = int(np.median(between)) if len(between) else 0
        if every >= 1:
            middle = float(np.median(delay))
            lengths["SYNC"] = _ticks((delay - middle)[1:]) + first_value(every, 8)
            lengths["SYNC"] += int(np.count_nonzero(between != every)) * EXCEPTION_BITS
            by_sync = float(np.std(delay)), every, middle
    best = min(lengths, key=lambda cause: lengths[cause])
    total = math.fsum(2.0 ** max(lengths[best] - each, -1000.0) for each in lengths.values())
    return Sending(best, 1.0 / total, median_interval, *(by_sync if best == "SYNC" else without_sync))


def _ticks(seconds: NDArray[np.float64]) -> float:
    return residual_code(np.rint(seconds / TICK).astype(np.int64))
