"""Node states, SYNC and signs of a master, by the frames on a bus."""

from __future__ import annotations

from collections import Counter, deque
from dataclasses import dataclass, field
from itertools import pairwise
from statistics import median
from typing import TYPE_CHECKING

from omnimate.files.logs.canopen_words import EMCY, HEARTBEAT, NMT_ID, SDO_ANSWER, SDO_REQUEST, SYNC_ID

if TYPE_CHECKING:
    import can

RPDOS = (0x200, 0x300, 0x400, 0x500)  # of the predefined connection set
MAX_TIMES = 200  # SYNCs or heartbeats of which the times are stored


@dataclass(slots=True)
class BusTraffic:
    """Node states, SYNCs, signs of a master and PDOs by the frames of a bus."""

    # NMT state of each node in its last heartbeat or node guarding answer; 0 is boot-up
    states: dict[int, int] = field(default_factory=dict)
    # times of the last heartbeats of each node [s]
    beats: dict[int, deque[float]] = field(default_factory=dict)
    guarded: set[int] = field(default_factory=set)  # nodes that a master guards by remote frames
    nodes: set[int] = field(default_factory=set)  # nodes that sent a frame: heartbeat, SDO answer or EMCY
    foreign_sdo: set[int] = field(default_factory=set)  # nodes to which another master sends SDO requests
    # times of the last SYNCs [s]
    syncs: deque[float] = field(default_factory=lambda: deque(maxlen=MAX_TIMES))
    has_counter: bool = False  # whether SYNC has a counter
    # number of frames that only a master sends, by kind
    masters: Counter[str] = field(default_factory=Counter)
    pdos: Counter[int] = field(default_factory=Counter)  # number of frames of every other identifier

    @property
    def sync_period(self) -> float | None:
        """Median time between two SYNCs [s], None before there are two."""
        return _period(self.syncs)

    def heartbeat_period(self, node: int) -> float | None:
        """Return the median time between two heartbeats of a node [s], None before there are two."""
        return _period(self.beats.get(node, ()))

    def take(self, message: can.Message, arrival: float) -> None:
        """Take a frame that was on the bus at a time [s]; frames that are not CANopen's are ignored."""
        if message.is_extended_id or message.is_error_frame or message.is_fd:
            return
        can_id, data = message.arbitration_id, bytes(message.data)
        function, node = can_id & 0x780, can_id & 0x7F
        if can_id == SYNC_ID:
            self.syncs.append(arrival)
            self.has_counter = len(data) == 1
            self.masters["SYNC"] += 1
        elif can_id == NMT_ID:
            self.masters["NMT commands"] += 1
        elif function == HEARTBEAT and node:
            self._heartbeat(node, data, arrival, is_asked=message.is_remote_frame)
        elif function == SDO_REQUEST and node:
            self.foreign_sdo.add(node)
            self.masters["SDO requests"] += 1
        elif function in {SDO_ANSWER, EMCY} and node:
            self.nodes.add(node)
        elif function < SDO_ANSWER:
            self.pdos[can_id] += 1
            if function in RPDOS:
                self.masters["PDOs to drives or outputs"] += 1

    def _heartbeat(self, node: int, data: bytes, arrival: float, *, is_asked: bool) -> None:
        if is_asked:
            self.guarded.add(node)
            self.masters["node guarding"] += 1
        elif len(data) == 1:
            self.nodes.add(node)
            self.states[node] = data[0] & 0x7F
            if data[0]:
                self.beats.setdefault(node, deque(maxlen=MAX_TIMES)).append(arrival)


def _period(times: deque[float] | tuple[()]) -> float | None:
    return median(later - earlier for earlier, later in pairwise(times)) if len(times) > 1 else None
