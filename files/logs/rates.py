"""Rates of all identifiers on a bus."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from omnimate.files.logs.filters import frame_kinds
from omnimate.files.logs.frames import EXTENDED

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from omnimate.files.logs.decoding import FrameDecoder
    from omnimate.files.logs.frames import Frames

PAUSE, PAUSE_INTERVALS = 1.0, 10.0  # [s], [median intervals]: a longer interval than both is a pause
MIN_INTERVAL = 1e-6  # [s] of the first bin of intervals
BINS_PER_DECADE = 50  # bins for each power of ten, 5 % wide
_BINS = 13 * BINS_PER_DECADE
_HEADER = f"{'interface':<10} {'id':>8} {'frames':>9} {'Hz':>10} {'bytes':>5}  name"


def are_pauses(intervals: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return whether each of at least one interval [s] of an identifier is a pause, shape `(N,)`."""
    return intervals > max(PAUSE, PAUSE_INTERVALS * float(np.median(intervals)))


def without_pauses(intervals: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the intervals [s], shape `(N,)`, of which none is a pause of an identifier, shape `(K,)`."""
    return intervals[~are_pauses(intervals)]


@dataclass(slots=True)
class IdentifierRate:
    """Statistics of the frames of an identifier so far.

    Flags and data are those of its first frame, `low` and `high` its shortest and longest length [bytes],
    `last` is the time of the last frame [s]. `short` is the number of intervals of at most `PAUSE`, `span`
    their sum [s]; `long` are the others [s], few in any log, because they are long. The histogram counts
    intervals of each size, `(BINS,)`.
    """

    flags: int
    data: bytes
    frames: int = 0
    low: int = 0xFF
    high: int = 0
    last: float | None = None
    short: int = 0
    span: float = 0.0
    long: list[float] = field(default_factory=list)
    histogram: NDArray[np.int64] = field(default_factory=lambda: np.zeros(_BINS, np.int64))

    def add(self, time: NDArray[np.float64], length: NDArray[np.uint8]) -> None:
        """Count frames that came at times [s], `(N,)`, in their order."""
        self.frames += len(time)
        self.low, self.high = min(self.low, int(length.min())), max(self.high, int(length.max()))
        intervals = np.diff(time if self.last is None else np.concatenate(([self.last], time)))
        self.last = float(time[-1])
        is_short = intervals <= PAUSE
        self.short += int(np.count_nonzero(is_short))
        self.span += float(intervals[is_short].sum())
        self.long += intervals[~is_short].tolist()
        bins = np.log10(np.maximum(intervals, MIN_INTERVAL) / MIN_INTERVAL) * BINS_PER_DECADE
        self.histogram += np.bincount(np.minimum(bins.astype(np.int64), _BINS - 1), minlength=_BINS)

    @property
    def in_words(self) -> str:
        """Mean rate [Hz] over the time in which the identifier was there, `-` for a single frame.

        Pauses of more than a second and ten median intervals are not counted.
        """
        longest = max(PAUSE, PAUSE_INTERVALS * self._median())
        there = [interval for interval in self.long if interval <= longest]
        span = self.span + sum(there)
        return f"{(self.short + len(there)) / span:.3f}" if span > 0 else "-"

    def _median(self) -> float:
        """Return the median interval [s] to the resolution of the bins."""
        middle = np.searchsorted(np.cumsum(self.histogram), 0.5 * self.histogram.sum())
        return float(MIN_INTERVAL * 10.0 ** ((int(middle) + 0.5) / BINS_PER_DECADE))


class RateTable:
    """The rates of all identifiers of a log or bus that comes block by block."""

    def __init__(self) -> None:
        self._rates: dict[str, dict[int, IdentifierRate]] = {}  # by interface, and identifier with its kind

    def add(self, frames: Frames) -> None:
        """Count the frames of the next block."""
        kind = frame_kinds(frames)
        order = np.argsort(kind, kind="stable")
        for rows in np.split(order, np.flatnonzero(np.diff(kind[order])) + 1) if len(frames) else ():
            first = int(rows[0])
            rates = self._rates.setdefault(frames.channels[int(frames.channel[first])], {})
            number = int(kind[first]) & (1 << 40) - 1
            if number not in rates:
                data = frames.data[first, : int(frames.length[first])].tobytes()
                rates[number] = IdentifierRate(int(frames.flags[first]), data)
            rates[number].add(frames.time[rows], frames.length[rows])

    def lines(self, decoder: FrameDecoder) -> Iterator[str]:
        """Yield a table: per interface and identifier the frames, their rate [Hz], length and name."""
        yield _HEADER
        for channel, rates in self._rates.items():
            for number, rate in sorted(rates.items()):
                can_id = number & 0xFFFFFFFF
                identifier = f"{can_id:08X}" if rate.flags & EXTENDED else f"{can_id:03X}"
                size = f"{rate.low}" if rate.low == rate.high else f"{rate.low}-{rate.high}"
                name = decoder.name(can_id, rate.flags, rate.data)
                yield f"{channel:<10} {identifier:>8} {rate.frames:>9} {rate.in_words:>10} {size:>5}  {name}"
