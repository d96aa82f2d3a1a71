"""Frames that nothing in the driver expects, counted by what they are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from omnimate.files.logs.canopen_words import describe_frame

if TYPE_CHECKING:
    from collections.abc import Mapping

    import can

    from omnimate.driver.robot.node_counts import NodeCounts

MAX_KINDS = 4096  # kinds of frame that are counted separately; further ones are counted together


@dataclass(slots=True)
class UnknownFrame:
    """One kind of frame that nothing expects.

    Attributes:
        description: What kind of frame it is, in words.
        count: Number of such frames.
    """

    description: str
    count: int = 0


class UnknownFrames:
    """Counts frames that nothing expects, of the vehicle's nodes and of unknown nodes.

    Args:
        counts: Frame counters by node id; `unknown` of a node's counter grows with its unknown frames.

    Attributes:
        kinds: Kinds of frame by identifier as text, such as `3FFh` or `181h remote`.
    """

    def __init__(self, counts: Mapping[int, NodeCounts]) -> None:
        self.kinds: dict[str, UnknownFrame] = {}
        self._counts = counts

    def count(self, message: can.Message) -> None:
        """Count a frame; also for a node of the vehicle if its 11-bit identifier belongs to one."""
        key = _key(message)
        if key not in self.kinds:
            if len(self.kinds) >= MAX_KINDS:
                key = "others"
            self.kinds.setdefault(key, UnknownFrame(_describe(message)))
        self.kinds[key].count += 1
        node = message.arbitration_id & 0x7F
        if not message.is_extended_id and node in self._counts:
            self._counts[node].unknown += 1


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
