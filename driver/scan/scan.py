"""Finds every node of a bus by listening and by SDO reading; nothing is changed unless an id is to be given.

Where another master works, a robot may drive: only nodes that were heard are read then, slowly, and none to
which that master talks by SDO, because a server has one dialogue at a time (CiA 301).
"""

from __future__ import annotations

import math
import time
from collections import Counter, deque
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from omnimate.driver.bus.clock import WallClock
from omnimate.driver.canopen.lss import MASTER, SLAVE, LssMaster
from omnimate.driver.canopen.network import BusNetwork
from omnimate.driver.canopen.node_access import PERIOD, MasterActiveError
from omnimate.driver.conformance.probe import MAX_DRAINED
from omnimate.driver.scan.node import NodeReading, ServerBusyError, read_node
from omnimate.driver.scan.traffic import BusTraffic
from omnimate.files.logs.canopen_words import BOOT_UP, HEARTBEAT, OPERATIONAL, SDO_ANSWER, SDO_REQUEST

if TYPE_CHECKING:
    from collections.abc import Callable

    import can

    from omnimate.driver.canopen.lss import Identity

NODES = range(1, 128)
LISTENING = 1.1  # [s] before anything is sent; most heartbeats have a period of 1 s at most
# [s] between two requests; an SDO request and its answer take 2.2 ms at 125 kbit/s (135 bits each with all
# stuff bits, ISO 11898-1). The second one while another master works.
PACE, POLITE_PACE = 0.002, 0.01
DEVICE_TYPE = b"\x40\x00\x10\x00".ljust(8, b"\0")  # request to read 1000h
LSS_TIMEOUT = 0.1  # [s], as of `omnimate lss`


@dataclass(frozen=True, slots=True)
class Scan:
    """The nodes and the traffic of a bus."""

    # objects that were read from each node, in the order of their ids; of a node that was heard and does not
    # answer, the id and a remark
    nodes: tuple[NodeReading, ...]
    traffic: BusTraffic  # NMT states, SYNCs, masters and PDOs by the frames on the bus
    # identities of the devices without a node id; empty where they were not asked for
    without_id: tuple[Identity, ...] = ()
    # node ids that were given, with the identity of the device
    given: dict[int, Identity] = field(default_factory=dict)
    # number of frames that were sent, by kind: LSS or SDO readings
    sent: Counter[str] = field(default_factory=Counter)
    has_other_master: bool = False  # whether another master works on the bus

    def state(self, node: NodeReading) -> int | None:
        """Return the NMT state of a node by its heartbeat, or by PDOs that only an operational node sends."""
        known = self.traffic.states.get(node.node)
        if known:
            return known
        sends = any(self.traffic.pdos[tpdo.cob_id] for tpdo in node.tpdos if tpdo.is_valid)
        return OPERATIONAL if sends else known


def scan(
    bus: can.BusABC,
    url: str,
    *,
    wait: float = 2.0,
    timeout: float = 0.5,
    asks_lss: bool = False,
    first_id: int | None = None,
    force: bool = False,
    progress: Callable[[int, int], None] = lambda _done, _total: None,
) -> Scan:
    """Return the nodes on a bus, with what was read from them.

    Args:
        bus: The bus.
        url: URL of the bus, for errors.
        wait: Time after all have been read in which late nodes may boot [s].
        timeout: Time in which a node answers [s].
        asks_lss: Whether to look for devices without a node id by LSS fastscan (CiA 305).
        first_id: First node id for them, then the next ones that are free; None for giving none.
        force: Whether LSS is used, and all ids are asked, even while another master works.
        progress: Called with the number of nodes that have been read, and with how many there are so far.

    Raises:
        BusLost: The interface failed.
        MasterActiveError: Another master works there, and LSS was asked for.
    """
    scanner = _Scanner(bus, timeout)
    scanner.listen(LISTENING)
    has_master = bool(scanner.traffic.masters)
    if has_master and asks_lss and not force:
        raise MasterActiveError(url)
    scanner.is_polite = has_master and not force
    scanner.sweep(sorted(scanner.traffic.nodes) if scanner.is_polite else NODES)
    scanner.read_due(progress)
    without_id, given = scanner.assign_ids(first_id) if asks_lss else ((), {})
    end = time.monotonic() + wait
    while (left := end - time.monotonic()) > 0.0:
        scanner.pump(left)
        scanner.read_due(progress)
    nodes = tuple(reading for _, reading in sorted(scanner.readings.items()))
    return Scan(nodes, scanner.traffic, without_id, given, scanner.sent, has_master)


class _Scanner(BusNetwork):
    """A scan in progress: a network with a pause between the frames that it sends, in which it reads.

    It `is_polite` where another master is not to be disturbed.
    """

    def __init__(self, bus: can.BusABC, timeout: float) -> None:
        super().__init__(bus, WallClock(PERIOD))
        self.traffic = BusTraffic()
        self.sent: Counter[str] = Counter()
        self.readings: dict[int, NodeReading] = {}
        self.is_polite = False
        self.handler = self._take
        self._timeout = timeout
        self._last_sent = -math.inf
        self._due: set[int] = set()
        self._reading: int | None = None
        self._lss_answers: deque[bytes] = deque(maxlen=8)

    def send_message(self, can_id: int, data: bytes, remote: bool = False) -> None:
        """Send a frame when its time has come; errors as of `BusNetwork`."""
        pace = POLITE_PACE if self.is_polite else PACE
        while (left := self._last_sent + pace - time.monotonic()) > 0.0:
            self.pump(left)
        self._last_sent = time.monotonic()
        super().send_message(can_id, data, remote)
        self.sent["LSS" if can_id == MASTER else "SDO readings"] += 1

    def listen(self, seconds: float) -> None:
        """Receive for so many seconds."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0.0:
            self.pump(left)

    def sweep(self, nodes: range | list[int]) -> None:
        """Request the device type of nodes; those that answer are read later."""
        for node in nodes:
            if not (self.is_polite and node in self.traffic.foreign_sdo):
                self.send_message(SDO_REQUEST + node, DEVICE_TYPE)
        self.listen(self._timeout)

    def read_due(self, progress: Callable[[int, int], None]) -> None:
        """Read the nodes that were heard and have not been read since."""
        while self._due:
            node = min(self._due)
            self._due.discard(node)
            self.readings[node] = self._read(node)
            progress(len(self.readings), len(self.readings) + len(self._due))

    def assign_ids(self, first_id: int | None) -> tuple[tuple[Identity, ...], dict[int, Identity]]:
        """Return the devices without a node id by LSS, and by new id those that got one."""
        master = LssMaster(self)
        without_id: list[Identity] = []
        given: dict[int, Identity] = {}
        while (identity := master.fastscan()) is not None and len(without_id) < len(NODES):
            without_id.append(identity)
            free = (node for node in NODES if node not in self.readings and node not in given)
            node = next((node for node in free if node >= (first_id or 0)), None)
            if first_id is None or node is None:
                continue  # it stays in configuration, so that the next scan finds another one
            if master.configure_id(node):
                given[node] = identity
            master.leave()
        master.leave()
        return tuple(without_id), given

    def send(self, can_id: int, data: bytes = b"") -> None:
        """Send a frame of the LSS master."""
        self.send_message(can_id, data)

    def drain(self) -> None:
        """Drop the LSS answers that have come: several devices may have answered the last question."""
        for _ in range(MAX_DRAINED):
            message = self.receive(0.0)
            if message is None:
                break
            self._take(message, self.arrival)
        self._lss_answers.clear()

    def await_frame(self, can_id: int, seconds: float | None = None) -> bytes | None:
        """Return the data of the next LSS answer, or None where none comes in time."""
        del can_id
        end = time.monotonic() + (LSS_TIMEOUT if seconds is None else seconds)
        while not self._lss_answers and (left := end - time.monotonic()) > 0.0:
            self.pump(left)
        return self._lss_answers.popleft() if self._lss_answers else None

    def _read(self, node: int) -> NodeReading:
        if self.is_polite and node in self.traffic.foreign_sdo:
            return NodeReading(node, remark=ServerBusyError(node).problem)
        if self.is_polite and self.traffic.states.get(node) == BOOT_UP:
            return NodeReading(node, remark="has just booted; it is left to the other master")
        self._reading = node
        try:
            sdo = self.sdo(node, timeout=self._timeout)
            return read_node(sdo) if sdo.answers() else NodeReading(node, remark="does not answer SDO")
        except ServerBusyError as error:
            return NodeReading(node, remark=error.problem)
        finally:
            self._reading = None

    def _take(self, message: can.Message, arrival: float) -> None:
        self.traffic.take(message, arrival)
        function, node = message.arbitration_id & 0x780, message.arbitration_id & 0x7F
        is_boot = function == HEARTBEAT and bytes(message.data) == b"\0"
        if node in self.traffic.nodes and (is_boot or node not in self.readings) and node != self._reading:
            self._due.add(node)
        if message.arbitration_id == SLAVE:
            self._lss_answers.append(bytes(message.data))
        elif function == SDO_REQUEST and node == self._reading and self.is_polite:
            raise ServerBusyError(node)
        elif function == SDO_ANSWER:
            self.notify(message.arbitration_id, message.data, message.timestamp)
