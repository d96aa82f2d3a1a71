"""Filters of frames by identifier, node, kind and time, or around an event."""

from __future__ import annotations

import operator
import re
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from omnimate.files.logs.canopen_words import SYNC_ID
from omnimate.files.logs.frame_classes import CLASSES, classify
from omnimate.files.logs.frames import ERROR, EXTENDED, FD, REMOTE
from omnimate.files.logs.signals import EXTENDED_KEY
from omnimate.vehicle.errors import OmnimateError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from numpy.typing import NDArray

    from omnimate.files.logs.frames import Frames
    from omnimate.files.logs.signals import Signal

    Mask = NDArray[np.bool_]

MAX_STANDARD_ID, MAX_EXTENDED_ID = 0x7FF, 0x1FFFFFFF
KINDS: Mapping[str, tuple[str, ...]] = {
    "nmt": ("NMT",),
    "sync": ("SYNC",),
    "emcy": ("EMCY",),
    "time": ("TIME",),
    "pdo": ("PDO", "unknown PDO"),
    "sdo": ("SDO",),
    "heartbeat": ("heartbeat",),
    "lss": ("LSS",),
    "remote": ("remote",),
    "error": ("error",),
    "foreign": ("foreign",),
}
_RULE = re.compile(r"(~?)(?:0x)?([0-9A-Fa-f]+)h?(?:([-:])(?:0x)?([0-9A-Fa-f]+)h?)?")
_GAP = re.compile(r"gap\s*[:=>]\s*(\d+(?:\.\d*)?)")
_VALUE = re.compile(r"\s*([^<>=!]+?)\s*(<=|>=|==|!=|<|>|=)\s*(-?[\d.]+(?:[eE]-?\d+)?)\s*")
_OPERATORS: Mapping[str, Callable[[NDArray[np.float64], float], Mask]] = {
    "<": operator.lt,
    ">": operator.gt,
    "<=": operator.le,
    ">=": operator.ge,
    "=": operator.eq,
    "==": operator.eq,
    "!=": operator.ne,
}


class FilterError(OmnimateError):
    """A filter or trigger with invalid syntax or an unknown name."""


@dataclass(frozen=True, slots=True)
class IdentifierRule:
    """Identifiers of a range or of a mask, of 11 or of 29 bits.

    `first` and `last` are the ends of a range, or the bits behind the mask and the mask.
    """

    first: int
    last: int
    is_mask: bool = False
    is_long: bool = False
    is_excluded: bool = False

    @classmethod
    def of(cls, text: str) -> IdentifierRule:
        """Return the rule of `181`, `180-1FF`, `700:780` (identifier and mask), or `~080` (all others).

        Identifiers are hexadecimal, also as `0x181` or `181h`; those of more than three digits have 29 bits.

        Raises:
            FilterError: The text is no such rule.
        """
        match = _RULE.fullmatch(text.strip())
        if match is None:
            raise FilterError(f"identifier {text!r}: expected 181, 180-1FF, 700:780 or ~080, hexadecimal")
        is_long = len(match[2]) > 3
        first = int(match[2], 16)
        is_mask = match[3] == ":"
        last = int(match[4], 16) if match[4] else first
        if max(first, last) > (MAX_EXTENDED_ID if is_long else MAX_STANDARD_ID) or (
            not is_mask and last < first
        ):
            raise FilterError(
                f"identifier {text!r}: expected up to 7FF, or 8 digits up to 1FFFFFFF, in order"
            )
        return cls(first, last, is_mask, is_long, match[1] == "~")

    def holds(self, frames: Frames) -> Mask:
        """Return which frames have an identifier of the range or mask, shape `(N,)`."""
        is_long = frames.flags & EXTENDED > 0
        if self.is_mask:
            fits = frames.can_id & self.last == self.first & self.last
        else:
            fits = (frames.can_id >= self.first) & (frames.can_id <= self.last)
        return np.asarray(fits & (is_long == self.is_long) & (frames.flags & ERROR == 0), np.bool_)


@dataclass(frozen=True, slots=True)
class FrameFilter:
    """A filter of frames; an empty part accepts all.

    Of the rules that name identifiers one must hold, and none of those that exclude. Nodes are CANopen node
    ids that a frame concerns; NMT concerns the one that it names, or all. Kinds are names in `KINDS`; `begin`
    and `end` are times after the first frame [s], None for all.
    """

    rules: tuple[IdentifierRule, ...] = ()
    nodes: tuple[int, ...] = ()
    kinds: tuple[str, ...] = ()
    begin: float | None = None
    end: float | None = None

    def wants(self, frames: Frames, start: float | None = None) -> Mask:
        """Return which frames are wanted, shape `(N,)`; `start` is the time of the first frame of all [s]."""
        wanted = np.ones(len(frames), np.bool_)
        if not len(frames):
            return wanted
        named = [rule for rule in self.rules if not rule.is_excluded]
        if named:
            wanted &= np.any([rule.holds(frames) for rule in named], axis=0)
        for rule in self.rules:
            if rule.is_excluded:
                wanted &= ~rule.holds(frames)
        if self.nodes:
            wanted &= np.any([_concerns(frames, node) for node in self.nodes], axis=0)
        if self.kinds:
            names = [name for kind in self.kinds for name in KINDS[kind]]
            wanted &= np.isin(classify(frames), [CLASSES.index(name) for name in names])
        since = frames.time - (frames.time[0] if start is None else start)
        if self.begin is not None:
            wanted &= since >= self.begin
        if self.end is not None:
            wanted &= since <= self.end
        return wanted


def _concerns(frames: Frames, node: int) -> Mask:
    """Return which frames concern a node by the predefined connections, shape `(N,)`."""
    can_id = frames.can_id
    from_node = (can_id & 0x7F == node) & (can_id > SYNC_ID) & (can_id < 0x780) & (can_id & 0x780 != 0x100)
    nmt = (can_id == 0) & np.isin(frames.data[:, 1], (0, node)) & (frames.length == 2)
    return np.asarray((from_node | nmt) & (frames.flags & (EXTENDED | ERROR | FD) == 0), np.bool_)


@dataclass(slots=True)
class GapTrigger:
    """An identifier appears again after a gap.

    `longest` is the longest interval that is no gap [s].
    """

    longest: float
    _kinds: NDArray[np.uint64] = field(default_factory=lambda: np.empty(0, np.uint64))
    _times: NDArray[np.float64] = field(default_factory=lambda: np.empty(0))

    def rows(self, frames: Frames) -> NDArray[np.int64]:
        """Return the frames of the next block that end a gap, shape `(K,)`."""
        carried_count = len(self._kinds)
        kind = np.concatenate((self._kinds, frame_kinds(frames)))
        time = np.concatenate((self._times, frames.time))
        order = np.argsort(kind, kind="stable")
        is_next = np.diff(kind[order]) == 0
        away = (np.diff(time[order]) > self.longest) & is_next
        last = order[np.append(~is_next, True)] if len(order) else order
        self._kinds, self._times = kind[last], time[last]
        return np.sort(order[1:][away]) - carried_count


@dataclass(frozen=True, slots=True)
class KindTrigger:
    """A frame of a kind comes: an EMCY that is no reset, or an error frame.

    The kind is `emcy` or `error`.
    """

    kind: str

    def rows(self, frames: Frames) -> NDArray[np.int64]:
        """Return the frames of the kind, shape `(K,)`."""
        matches = FrameFilter(kinds=(self.kind,)).wants(frames)
        if self.kind == "emcy":
            matches &= (frames.data[:, 0] > 0) | (frames.data[:, 1] > 0)
        return np.flatnonzero(matches)


@dataclass(slots=True)
class ValueTrigger:
    """A signal's value begins to satisfy a comparison.

    The comparison is one of < > <= >= = !=, with a physical value.
    """

    rule: IdentifierRule
    signal: Signal
    comparison: str
    value: float
    _holds: bool = False

    def rows(self, frames: Frames) -> NDArray[np.int64]:
        """Return the frames of the next block in which the comparison begins to hold, shape `(K,)`."""
        rows = np.flatnonzero(self.rule.holds(frames) & (frames.flags & REMOTE == 0))
        values = self.signal.values(frames.select(rows))
        holds = _OPERATORS[self.comparison](values, self.value) & ~np.isnan(values)
        begins = holds & ~np.concatenate(([self._holds], holds[:-1]))
        self._holds = bool(holds[-1]) if len(holds) else self._holds
        return rows[begins]


Trigger = GapTrigger | KindTrigger | ValueTrigger  # their rows are frames of the next block of a log


def trigger_of(text: str, signals: Mapping[int, Sequence[Signal]]) -> Trigger:
    """Return the trigger of `gap:0.5`, `emcy`, `error` or `NAME>VALUE`.

    Signals are by identifier, to which `EXTENDED_KEY` is added for 29 bits.

    Raises:
        FilterError: The text is no trigger, or names a signal that is not known.
    """
    if text in {"emcy", "error"}:
        return KindTrigger(text)
    if match := _GAP.fullmatch(text):
        return GapTrigger(float(match[1]))
    match = _VALUE.fullmatch(text)
    if match is None:
        raise FilterError(f"trigger {text!r}: expected gap:SECONDS, emcy, error, or NAME>VALUE")
    for key, carried in signals.items():
        for signal in carried:
            if signal.name == match[1]:
                can_id = key & ~EXTENDED_KEY
                rule = IdentifierRule(can_id, can_id, is_long=bool(key & EXTENDED_KEY))
                return ValueTrigger(rule, signal, match[2], float(match[3]))
    names = ", ".join(sorted(signal.name for carried in signals.values() for signal in carried))
    raise FilterError(
        f"trigger {text!r}: no signal {match[1]!r}; expected one of {names or 'a --vehicle, --dbc or --eds'}"
    )


def within_seconds(frames: Frames, times: NDArray[np.float64], seconds: float) -> Mask:
    """Return which frames are at most so many seconds before or after some times (K,), shape `(N,)`."""
    if not len(times):
        return np.zeros(len(frames), np.bool_)
    ordered = np.sort(times)
    after = np.searchsorted(ordered, frames.time - seconds)
    nearest = ordered[np.minimum(after, len(ordered) - 1)]
    return np.asarray(
        (after < len(ordered)) & (nearest <= frames.time + seconds) & (nearest >= frames.time - seconds)
    )


def frame_kinds(frames: Frames) -> NDArray[np.uint64]:
    """Return a number for interface, identifier and kind of each frame, shape `(N,)`."""
    kind = frames.channel.astype(np.uint64) << np.uint64(40) | frames.can_id
    return kind | (frames.flags & (EXTENDED | REMOTE | ERROR | FD)).astype(np.uint64) << np.uint64(32)
