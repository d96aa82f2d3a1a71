"""How often each identifier was on the bus."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omnimate.logs.frames import ERROR, EXTENDED, REMOTE

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from omnimate.logs.decoding import FrameDecoder
    from omnimate.logs.frames import Frames

PAUSE, PAUSE_INTERVALS = 1.0, 10.0  # [s] and usual intervals: an identifier that is away for longer pauses
_HEADER = f"{'interface':<10} {'id':>8} {'frames':>9} {'Hz':>10} {'bytes':>5}  name"


def rate_lines(frames: Frames, decoder: FrameDecoder) -> Iterator[str]:
    """Yield a table: per interface and identifier the frames, their rate [Hz], length and name.

    The rate is the mean over the time in which the identifier was there: a pause of more than a second and
    ten of its usual intervals does not count.
    """
    yield _HEADER
    kind = (frames.flags & (EXTENDED | REMOTE | ERROR)).astype(np.uint64)
    key = frames.channel.astype(np.uint64) << np.uint64(40) | kind << np.uint64(32) | frames.can_id
    order = np.argsort(key, kind="stable")
    for rows in np.split(order, np.flatnonzero(np.diff(key[order])) + 1) if len(frames) else ():
        first = int(rows[0])
        rate = _rate(frames.time[rows])
        low, high = int(frames.length[rows].min()), int(frames.length[rows].max())
        size = f"{low}" if low == high else f"{low}-{high}"
        flags, can_id = int(frames.flags[first]), int(frames.can_id[first])
        identifier = f"{can_id:08X}" if flags & EXTENDED else f"{can_id:03X}"
        name = decoder.name(can_id, flags, frames.data[first, : int(frames.length[first])].tobytes())
        channel = frames.channels[int(frames.channel[first])]
        yield f"{channel:<10} {identifier:>8} {len(rows):>9} {rate:>10} {size:>5}  {name}"


def without_pauses(intervals: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the intervals [s], shape `(N,)`, of which none is a pause of an identifier, shape `(K,)`."""
    return intervals[intervals <= max(PAUSE, PAUSE_INTERVALS * float(np.median(intervals)))]


def _rate(time: NDArray[np.float64]) -> str:
    """Return the rate [Hz] of frames that came at times [s], shape `(N,)`."""
    intervals = np.diff(time)
    if len(intervals) == 0:
        return "-"
    there = without_pauses(intervals)
    span = float(there.sum())
    return f"{len(there) / span:.3f}" if span > 0 else "-"
