"""Frames that nobody here expects: counted by what they are, and who floods the bus with them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from vehicle.canopen_words import describe_frame

if TYPE_CHECKING:
    from collections.abc import Mapping

    import can

    from driver.events import EventLog
    from driver.fields import NodeCounts

INTERVAL = 0.5  # [s] between two looks at who floods
FACTOR = 3  # unexpected frames per SYNC above which it is called babbling
AT_LEAST = 10  # SYNCs: a bus that starts up is allowed its talk
MAX_KINDS = 4096  # that are counted one by one


@dataclass(slots=True)
class Stranger:
    """One kind of frame that nothing here expects.

    Attributes:
        what: in words.
        count: frames.
    """

    what: str
    count: int = 0


class Strangers:
    """Counts unknown frames, of our nodes and of others.

    Attributes:
        kinds: by identifier as text.
    """

    def __init__(self, counts: Mapping[int, NodeCounts], events: EventLog) -> None:
        self.kinds: dict[str, Stranger] = {}
        self._counts = counts
        self._events = events
        self._traffic: dict[int, int] = {}
        self._duplicates: dict[int, int] = {}
        self._checked: float | None = None
        self._syncs = 0

    def count(self, message: can.Message) -> None:
        """Count a frame that nothing expects; our node's, if its 11-bit identifier belongs to one."""
        key = _key(message)
        if key not in self.kinds:
            if len(self.kinds) >= MAX_KINDS:
                key = "others"
            self.kinds.setdefault(key, Stranger(_describe(message)))
        self.kinds[key].count += 1
        node = message.arbitration_id & 0x7F
        if not message.is_extended_id and node in self._counts:
            self._counts[node].unknown += 1

    def busy(self, can_id: int) -> None:
        """Note a frame that should be rare, known or not."""
        self._traffic[can_id] = self._traffic.get(can_id, 0) + 1

    def check(self, now: float) -> None:
        """Look, once per SYNC at `now` [s], whether somebody floods the bus."""
        self._syncs += 1
        if self._checked is not None and now - self._checked < INTERVAL:
            return
        limit = FACTOR * max(self._syncs, AT_LEAST)
        for can_id, frames in self._traffic.items():
            if frames > limit:
                self._babbles(now, can_id & 0x7F, f"floods the bus with frames {can_id:03X}h")
        for node, counts in self._counts.items():
            if counts.duplicate - self._duplicates.get(node, 0) > limit:
                self._babbles(now, node, "floods the bus with PDOs that no SYNC asked for")
            self._duplicates[node] = counts.duplicate
        self._traffic.clear()
        self._checked, self._syncs = now, 0

    def _babbles(self, now: float, node: int, what: str) -> None:
        known = node in self._counts
        self._events.add(now, node if known else None, f"babbles: {what}")


def _key(message: can.Message) -> str:
    if message.is_error_frame:
        return "error frame"
    key = f"{message.arbitration_id:08X}h" if message.is_extended_id else f"{message.arbitration_id:03X}h"
    return f"{key} remote" if message.is_remote_frame else key


def _describe(message: can.Message) -> str:
    if message.is_error_frame:
        return "the adapter reports an error on the bus"
    if message.is_extended_id:
        return "29-bit identifier, not CANopen"
    words = describe_frame(message.arbitration_id, bytes(message.data), remote=message.is_remote_frame)
    return words or "not CANopen"
