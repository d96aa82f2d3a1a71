"""Detection of events on a bus of any robot: EMCY, restarts, NMT states, SDO aborts, error frames."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from omnimate.files.logs.canopen_words import (
    BOOT_UP,
    EMCY,
    HEARTBEAT,
    NMT_ID,
    SDO_ANSWER,
    SDO_REQUEST,
    describe_frame,
    emergency_in_words,
    nmt_state_in_words,
)
from omnimate.files.logs.frames import ERROR, EXTENDED, FD, REMOTE

if TYPE_CHECKING:
    from omnimate.files.logs.frames import Frame

_ABORT = 0x80
_TOGGLE = 0x80
_OTHERS = EXTENDED | REMOTE | FD
_SIZES = {NMT_ID: 2, EMCY: 8, SDO_ANSWER: 8, SDO_REQUEST: 8, HEARTBEAT: 1}  # bytes, by function code


class BusEvent(NamedTuple):
    """An event on a bus.

    It concerns a node (id) or the bus (None), at a time [s]; `is_problem`: a fault, a restart or a refusal;
    `is_health`: an EMCY or an NMT state, by which a driver supervises a node.
    """

    time: float
    node: int | None
    what: str
    is_problem: bool = False
    is_health: bool = False


class NodeSeen(NamedTuple):
    """Last known NMT state of a node.

    The state is that in its last heartbeat, boot-up or node guarding answer, at a time [s].
    """

    state: int
    time: float


class BusEvents:
    """Detects events in the frames of a bus, by the predefined connection set of CiA 301.

    `nodes` has the last known NMT state of every node, by interface and node id.
    """

    def __init__(self) -> None:
        self.nodes: dict[tuple[str, int], NodeSeen] = {}

    def take(self, frame: Frame) -> BusEvent | None:
        """Return the event in a frame; None for nearly every frame."""
        if frame.flags & ERROR:
            return BusEvent(frame.time, None, "error frame of the adapter", is_problem=True)
        function, node = frame.can_id & 0x780, frame.can_id & 0x7F
        if (
            len(frame.data) != _SIZES.get(function)
            or frame.flags & _OTHERS
            or (node == 0) != (function == NMT_ID)
        ):
            return None
        if function == HEARTBEAT:
            return self._heartbeat(frame, node)
        return _emergency(frame, node) if function == EMCY else _command_or_abort(frame, node)

    def _heartbeat(self, frame: Frame, node: int) -> BusEvent | None:
        state = frame.data[0] & ~_TOGGLE
        before = self.nodes.get((frame.channel, node))
        self.nodes[frame.channel, node] = NodeSeen(state, frame.time)
        if frame.data[0] == BOOT_UP:
            return BusEvent(frame.time, node, "boot-up", before is not None, is_health=True)
        if before is None or before.state == state:
            return None
        words = f"is {nmt_state_in_words(state)}, was {nmt_state_in_words(before.state)}"
        return BusEvent(frame.time, node, words, is_health=True)


def _command_or_abort(frame: Frame, node: int) -> BusEvent | None:
    if node and frame.data[0] != _ABORT:
        return None
    words = describe_frame(frame.can_id, frame.data) or ""
    return BusEvent(frame.time, node or frame.data[1] or None, words, is_problem=node > 0)


def _emergency(frame: Frame, node: int) -> BusEvent:
    is_error = any(frame.data[:2])
    return BusEvent(frame.time, node, emergency_in_words(frame.data), is_error, is_health=True)
