"""The data frames of a log by identifier, with their PDO by the predefined connection set of CiA 301."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.files.logs.frames import ERROR, EXTENDED, REMOTE

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from omnimate.files.logs.frames import Frames
    from omnimate.listen.priors import Direction

# CiA 301, table 39: COB-IDs of the four PDOs that a node sends, and of the four that it receives, without
# node id.
TPDO_COB_IDS, RPDO_COB_IDS = (0x180, 0x280, 0x380, 0x480), (0x200, 0x300, 0x400, 0x500)


@dataclass(frozen=True, slots=True)
class Message:
    """The data frames of an identifier."""

    can_id: int  # identifier without flag bits
    is_extended: bool  # whether it has 29 bits
    time: NDArray[np.float64]  # times of the frames [s], shape `(N,)`
    data: NDArray[np.uint8]  # their data, shape `(N, length)`; frames of another length are left out
    other_lengths: int  # number of frames that are left out because their length is another
    node: int  # node that sends or receives it by the predefined connections; 0 for none
    pdo_number: int  # number of the node's PDO, 1 to 4; 0 if it is no PDO
    direction: Direction  # whether the node sends or receives it; `unknown` if it is no PDO

    @property
    def name(self) -> str:
        """Name for reports, such as `TPDO1 of node 5`."""
        if not self.pdo_number:
            return f"{self.can_id:08X}" if self.is_extended else f"{self.can_id:03X}"
        return f"{'T' if self.direction == 'sent' else 'R'}PDO{self.pdo_number} of node {self.node}"


def messages_of(frames: Frames, nodes: frozenset[int], *, has_sync: bool = False) -> Iterator[Message]:
    """Yield the messages that may be PDOs, in the order of their identifiers.

    A node is given only to messages of `nodes`, or, if there are none, to all messages of a bus with SYNC.

    Args:
        frames: The log.
        nodes: Ids of the nodes that were identified by heartbeat, boot-up or SDO.
        has_sync: Whether the log has SYNC frames.
    """
    is_data = frames.flags & (REMOTE | ERROR) == 0
    key = frames.can_id.astype(np.int64) | (frames.flags & EXTENDED).astype(np.int64) << 32
    for identifier_key in np.unique(key[is_data]).tolist():
        can_id, is_extended = identifier_key & 0x1FFFFFFF, bool(identifier_key >> 32)
        if (nodes or has_sync) and not is_extended and is_service(can_id):
            continue
        rows = np.flatnonzero((key == identifier_key) & is_data)
        length = int(np.bincount(frames.length[rows]).argmax())
        regular = rows[frames.length[rows] == length]
        if not length:
            continue
        node, number, direction = _pdo(can_id) if not is_extended else (0, 0, "unknown")
        if node not in nodes and (nodes or not has_sync):
            node, number, direction = 0, 0, "unknown"
        yield Message(
            can_id,
            is_extended,
            frames.time[regular],
            frames.data[regular, :length],
            len(rows) - len(regular),
            node,
            number,
            direction,
        )


def is_service(can_id: int) -> bool:
    """Return whether an identifier of 11 bits is that of a CANopen service other than PDO (CiA 301)."""
    return can_id <= 0x100 or 0x581 <= can_id <= 0x5FF or 0x601 <= can_id <= 0x67F or can_id >= 0x701


def _pdo(can_id: int) -> tuple[int, int, Direction]:
    base, node = can_id & 0x780, can_id & 0x7F
    if base in TPDO_COB_IDS:
        return node, TPDO_COB_IDS.index(base) + 1, "sent"
    if base in RPDO_COB_IDS:
        return node, RPDO_COB_IDS.index(base) + 1, "received"
    return 0, 0, "unknown"
