"""What each identifier of a live bus does: its rate, its jitter, its last data and which bytes changed."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from omnimate.files.logs.frames import ERROR, EXTENDED, FD, REMOTE
from omnimate.files.logs.rates import PAUSE, PAUSE_INTERVALS, without_pauses

if TYPE_CHECKING:
    from omnimate.files.logs.frames import Frame

MOST_IDENTIFIERS = 4096  # that are counted each for itself; a hostile bus may show half a billion
WINDOW = 200  # frames of an identifier over which rate and jitter are taken
CHANGED = 1.0  # [s] for which a byte counts as changed
_KIND = EXTENDED | REMOTE | ERROR | FD

Key = tuple[str, int, int]


class LiveRow(NamedTuple):
    """What one identifier did.

    Attributes:
        frame: Its last frame.
        frames: Number of its frames.
        rate: Frames per second over the last `WINDOW`; 0 where it is away, or came once.
        jitter: Standard deviation of the time from frame to frame over the last `WINDOW` [s].
        age: Time since its last frame [s].
        changed: Whether each byte of the data changed within the last `CHANGED` seconds.
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
        self.times: deque[float] = deque(maxlen=WINDOW)
        self.changed = [-CHANGED - 1.0 + heard] * len(frame.data)

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
            tuple([now - at <= CHANGED for at in self.changed]),
        )


class LiveTable:
    """Follows the identifiers of a bus, each interface and kind of frame for itself.

    Attributes:
        frames: Number of frames so far.
        others: Number of frames of identifiers beyond `MOST_IDENTIFIERS`.
    """

    def __init__(self) -> None:
        self.frames = self.others = 0
        self._identifiers: dict[Key, _Identifier] = {}

    def take(self, frame: Frame, heard: float) -> None:
        """Take a frame that was heard at a time on the clock that `rows` is asked with [s]."""
        self.frames += 1
        key = (frame.channel, frame.can_id, frame.flags & _KIND)
        identifier = self._identifiers.get(key)
        if identifier is None:
            if len(self._identifiers) >= MOST_IDENTIFIERS:
                self.others += 1
                return
            identifier = self._identifiers[key] = _Identifier(frame, heard)
        identifier.take(frame, heard)

    def rows(self, now: float) -> tuple[LiveRow, ...]:
        """Return what each identifier did until `now` [s], by interface, width and identifier."""
        order = sorted(self._identifiers, key=lambda key: (key[0], key[2] & EXTENDED, key[1], key[2]))
        return tuple([self._identifiers[key].row(now) for key in order])
