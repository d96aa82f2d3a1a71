"""Finds nodes that flood the bus with frames, so-called babbling nodes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.driver.canopen.heartbeat import DRIVE_HEARTBEAT_MS

if TYPE_CHECKING:
    from collections.abc import Mapping

    from omnimate.driver.robot.event_log import EventLog
    from omnimate.driver.robot.node_counts import NodeCounts

INTERVAL = 0.5  # [s] between two checks
FACTOR = 3  # unexpected frames per SYNC, or per heartbeat of a drive, above which a node counts as babbling
MOST = 0.8  # second answers per SYNC above which a second device answers
AT_LEAST = 10  # SYNCs: a bus that starts up may send this many times `FACTOR` frames


class FloodWatch:
    """Compares the number of frames that should be rare with the number of SYNCs.

    Args:
        counts: Frame counters by node id, of which the second answers to a SYNC are watched.
        events: Log that gets an event for each babbling node.
    """

    def __init__(self, counts: Mapping[int, NodeCounts], events: EventLog) -> None:
        self._counts = counts
        self._events = events
        self._traffic: dict[int, int] = {}
        self._duplicates: dict[int, int] = {}
        self._checked: float | None = None
        self._syncs = 0

    def note(self, can_id: int) -> None:
        """Count a frame that should be rare, known or not, by its 11-bit identifier."""
        self._traffic[can_id] = self._traffic.get(can_id, 0) + 1

    def check(self, now: float) -> list[int]:
        """Compare, once per SYNC at time `now` [s], whether a node floods the bus.

        Returns:
            The nodes that answered most SYNCs since the last check twice.
        """
        self._syncs += 1
        if self._checked is None:  # what came before the first SYNC came in a time that nobody knows
            self._traffic.clear()
            self._checked = now
        passed = now - self._checked
        if passed < INTERVAL:
            return []
        limit = FACTOR * max(self._syncs, AT_LEAST, 1000.0 * passed / DRIVE_HEARTBEAT_MS)
        for can_id, frames in self._traffic.items():
            if frames > limit:
                self._report(now, can_id & 0x7F, f"floods the bus with frames {can_id:03X}h")
        twice = []
        for node, counts in self._counts.items():
            duplicates = counts.duplicate - self._duplicates.get(node, 0)
            if duplicates > limit:
                self._report(now, node, "floods the bus with PDOs that no SYNC asked for")
            elif self._syncs >= AT_LEAST and duplicates > MOST * self._syncs:
                twice.append(node)
            self._duplicates[node] = counts.duplicate
        self._traffic.clear()
        self._checked, self._syncs = now, 0
        return twice

    def _report(self, now: float, node: int, problem: str) -> None:
        known = node in self._counts
        self._events.add(now, node if known else None, f"babbles: {problem}")
