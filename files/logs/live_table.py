"""Statistics of every identifier on a live bus: rate, jitter, last data, changed bytes."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from omnimate.files.logs.frames import ERROR, EXTENDED, FD, REMOTE
from omnimate.files.logs.rates import PAUSE, PAUSE_INTERVALS, are_pauses, without_pauses

if TYPE_CHECKING:
    from omnimate.files.logs.frames import Frame

MAX_IDENTIFIERS = 4096  # that are counted separately: bounds memory, as 29 bits allow half a billion
RATE_FRAMES = 200  # latest frames of an identifier for rate and jitter
SLOWER_AFTER = 3  # pauses in a row: the identifier has become slower
CHANGE_TIME = 1.0  # [s] for which a byte is marked as changed
_KIND = EXTENDED | REMOTE | ERROR | FD

Key = tuple[str, int, int]


class LiveRow(NamedTuple):
    """Statistics of one identifier.

    Attributes:
        frame: Its last frame.
        frames: Number of its frames.
        rate: Frames per second over the last `RATE_FRAMES`, or since it became slower; 0 if it is absent or
            came once.
        jitter: Standard deviation of the time from frame to frame over the last `RATE_FRAMES` [s].
        age: Time since its last frame [s].
        changed: Whether each byte of the data changed within the last `CHANGE_TIME` seconds.
    """

    frame: Frame
    frames: int
    rate: float
    jitter: float
    age: float
    changed: tuple[bool, ...]


class _Identifier:
    """The frames of one identifier so far."""

    __slots__ = ("changed", "count", "frame", "heard", "times")

    def __init__(self, frame: Frame, heard: float) -> None:
        self.frame = frame
        self.count = 0
        self.heard = heard
        self.times: deque[float] = deque(maxlen=RATE_FRAMES)
        self.changed = [-CHANGE_TIME - 1.0 + heard] * len(frame.data)

    def take(self, frame: Frame, heard: float) -> None:
        before = self.frame.data
        if frame.data != before:
            if len(frame.data) != len(before):
                self.changed = [heard] * len(frame.data)
            else:
                for place, byte in enumerate(frame.data):
                    if byte != before[place]:
                        self.changed[place] = heard
        self.frame = frame
        self.count += 1
        self.heard = heard
        self.times.append(frame.time)

    def row(self, now: float) -> LiveRow:
        intervals = np.diff(np.fromiter(self.times, np.float64, len(self.times)))
        if len(intervals) >= SLOWER_AFTER and (pauses := are_pauses(intervals))[-SLOWER_AFTER:].all():
            intervals = intervals[pauses]
        intervals = without_pauses(intervals) if len(intervals) else intervals
        age = max(0.0, now - self.heard)
        mean = float(intervals.mean()) if len(intervals) else 0.0
        is_away = mean <= 0.0 or age > max(PAUSE, PAUSE_INTERVALS * mean)
        return LiveRow(
            self.frame,
            self.count,
            0.0 if is_away else 1.0 / mean,
            float(intervals.std()) if len(intervals) > 1 else 0.0,
            age,
            tuple([now - at <= CHANGE_TIME for at in self.changed]),
        )


class LiveTable:
    """Collects statistics of identifiers, separately for each interface and kind of frame.

    `others` are frames of identifiers beyond `MAX_IDENTIFIERS`.
    """

    def __init__(self) -> None:
        self.frames = self.others = 0
        self._identifiers: dict[Key, _Identifier] = {}

    def take(self, frame: Frame, heard: float) -> None:
        """Add a frame that was received at time `heard` on the clock of `rows` [s]."""
        self.frames += 1
        key = (frame.channel, frame.can_id, frame.flags & _KIND)
        identifier = self._identifiers.get(key)
        if identifier is None:
            if len(self._identifiers) >= MAX_IDENTIFIERS:
                self.others += 1
                return
            identifier = self._identifiers[key] = _Identifier(frame, heard)
        identifier.take(frame, heard)

    def rows(self, now: float) -> tuple[LiveRow, ...]:
        """Return the statistics at time `now` [s], by interface, width and identifier."""
        order = sorted(self._identifiers, key=lambda key: (key[0], key[2] & EXTENDED, key[1], key[2]))
        return tuple([self._identifiers[key].row(now) for key in order])
