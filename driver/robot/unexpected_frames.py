"""Frames that the driver does not expect: unknown ones by kind, and nodes that flood the bus (babbling)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.driver.canopen.node_setup import DRIVE_HEARTBEAT_MS
from omnimate.files.logs.canopen_words import describe_frame

if TYPE_CHECKING:
    from collections.abc import Mapping

    import can

    from omnimate.driver.robot.events import EventLog, NodeCounts

# Limits of the driver; no standard states them.
MAX_KINDS = 4096  # counted separately: all 2048 11-bit identifiers, with data and remote; then together
CHECK_INTERVAL = 0.5  # [s] between two comparisons of frames with SYNCs
BABBLING_FACTOR = 3  # unexpected frames per SYNC, or per heartbeat of a drive; above, a node babbles
DUPLICATE_SHARE = 0.8  # duplicate answers per SYNC above which a second device answers
MIN_SYNCS = 10  # SYNCs: a bus that starts up may send this many times `BABBLING_FACTOR` frames


class UnknownFrames:
    """Counts frames that nothing expects, also per node, in `kinds` such as `3FFh` or `181h remote`."""

    def __init__(self, counts: Mapping[int, NodeCounts]) -> None:
        self.kinds: dict[str, int] = {}
        self._descriptions: dict[str, str] = {}
        self._counts = counts

    def count(self, message: can.Message) -> None:
        """Count a frame; also for a node of the vehicle if its 11-bit identifier belongs to one."""
        key = _key(message)
        count = self.kinds.get(key)
        if count is None:
            if len(self.kinds) >= MAX_KINDS:
                key = "others"
            self._descriptions.setdefault(key, _describe(message))
            count = self.kinds.get(key, 0)
        self.kinds[key] = count + 1
        node = message.arbitration_id & 0x7F
        if not message.is_extended_id and node in self._counts:
            self._counts[node].unknown += 1

    def rows(self) -> tuple[tuple[str, str, int], ...]:
        """Return identifier, description and number of frames of each kind."""
        return tuple((key, self._descriptions[key], count) for key, count in self.kinds.items())


def _key(message: can.Message) -> str:
    if message.is_error_frame:
        return "error frame"
    key = f"{message.arbitration_id:08X}h" if message.is_extended_id else f"{message.arbitration_id:03X}h"
    if message.is_fd:
        return f"{key} CAN FD"
    return f"{key} remote" if message.is_remote_frame else key


def _describe(message: can.Message) -> str:
    if message.is_error_frame:
        return "the adapter reports an error on the bus"
    if message.is_fd:
        return "a CAN FD frame, not CANopen"
    if message.is_extended_id:
        return "29-bit identifier, not CANopen"
    words = describe_frame(message.arbitration_id, bytes(message.data), remote=message.is_remote_frame)
    return words or "not CANopen"


class FloodDetector:
    """Finds babbling nodes by the number of frames, which should be rare, per SYNC."""

    def __init__(self, counts: Mapping[int, NodeCounts], events: EventLog) -> None:
        self._counts = counts
        self._events = events
        self._traffic: dict[int, int] = {}
        self._duplicates: dict[int, int] = {}
        self._checked: float | None = None
        self._syncs = 0
        self._foreign_syncs = 0

    def note(self, can_id: int) -> None:
        """Count a frame that should be rare, known or not, by its 11-bit identifier."""
        self._traffic[can_id] = self._traffic.get(can_id, 0) + 1

    def foreign_sync(self) -> None:
        """Count a SYNC of another device, which every node answers, too."""
        self._foreign_syncs += 1

    def check(self, now: float) -> list[int]:
        """Report nodes that flood the bus, once per SYNC at `now` [s]; return those that answer twice."""
        self._syncs += 1
        if self._checked is None:  # how long the frames before the first SYNC took is unknown
            self._traffic.clear()
            self._checked = now
        passed = now - self._checked
        if passed < CHECK_INTERVAL:
            return []
        limit = BABBLING_FACTOR * max(self._syncs, MIN_SYNCS, 1000.0 * passed / DRIVE_HEARTBEAT_MS)
        for can_id, frames in self._traffic.items():
            if frames > limit:
                self._report(now, can_id & 0x7F, f"floods the bus with frames {can_id:03X}h")
        duplicated = []
        for node, counts in self._counts.items():
            duplicates = counts.duplicate - self._duplicates.get(node, 0)
            if duplicates > limit:
                self._report(now, node, "floods the bus with PDOs that no SYNC asked for")
            elif (
                self._syncs >= MIN_SYNCS and duplicates - self._foreign_syncs > DUPLICATE_SHARE * self._syncs
            ):
                duplicated.append(node)
            self._duplicates[node] = counts.duplicate
        self._traffic.clear()
        self._checked, self._syncs, self._foreign_syncs = now, 0, 0
        return duplicated

    def _report(self, now: float, node: int, problem: str) -> None:
        known = node in self._counts
        self._events.add(now, node if known else None, f"babbles: {problem}")
