"""Finds every node of a bus by listening and by SDO reading; nothing is changed unless an id is to be given.

Where another master works, a robot may drive: only nodes that were heard are read then, slowly, and none to
which that master talks by SDO, because a server has one dialogue at a time (CiA 301).
"""

from __future__ import annotations

import time
from collections import Counter, deque
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from omnimate.driver.bus.clock import WallClock
from omnimate.driver.canopen.lss import MASTER, SLAVE, LssMaster
from omnimate.driver.canopen.network import BusNetwork
from omnimate.driver.canopen.node_access import PERIOD, MasterActiveError
from omnimate.driver.conformance.probe import MOST_DRAINED, Reply
from omnimate.driver.scan.node import NodeReading, ServerBusyError, read_node
from omnimate.driver.scan.traffic import BusTraffic
from omnimate.files.logs.canopen_words import BOOT_UP, HEARTBEAT, OPERATIONAL, SDO_ANSWER, SDO_REQUEST

if TYPE_CHECKING:
    from collections.abc import Callable

    import can

    from omnimate.driver.canopen.lss import Identity
    from omnimate.vehicle.parameters import VehicleParameters

NODES = range(1, 128)
LISTENING = 1.1  # [s] before anything is sent; most heartbeats have a period of 1 s at most
PACE, POLITE_PACE = 0.002, 0.01  # [s] between two requests; the second one while another master works
DEVICE_TYPE = b"\x40\x00\x10\x00".ljust(8, b"\0")  # request to read 1000h
LSS_TIMEOUT = 0.1  # [s], as of `omnimate lss`


@dataclass(frozen=True, slots=True)
class Scan:
    """Who is on a bus.

    Attributes:
        nodes: What the nodes say of themselves, in the order of their ids; of a node that was heard and does
            not answer, the id and a remark.
        traffic: What the frames on the bus say.
        without_id: Identities of the devices without a node id; empty where they were not asked for.
        given: Node ids that were given, with the identity of the device.
        sent: Number of frames that were sent, by what they are.
        has_other_master: Whether another master works on the bus.
    """

    nodes: tuple[NodeReading, ...]
    traffic: BusTraffic
    without_id: tuple[Identity, ...] = ()
    given: dict[int, Identity] = field(default_factory=dict)
    sent: Counter[str] = field(default_factory=Counter)
    has_other_master: bool = False

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
    """Return who is on a bus.

    Args:
        bus: The bus.
        url: What it is called in errors.
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
    found, given = scanner.lss(first_id) if asks_lss else ((), {})
    end = time.monotonic() + wait
    while (left := end - time.monotonic()) > 0.0:
        scanner.network.pump(left)
        scanner.read_due(progress)
    return Scan(scanner.nodes(), scanner.traffic, found, given, scanner.sent.frames, has_master)


class _Scanner:
    """A scan in progress."""

    def __init__(self, bus: can.BusABC, timeout: float) -> None:
        self.traffic = BusTraffic()
        self.sent = _Sent()
        self.network = _PacedNetwork(bus, WallClock(PERIOD), self.sent)
        self.network.handler = self._take
        self._timeout = timeout
        self._readings: dict[int, NodeReading] = {}
        self._due: set[int] = set()
        self._reading: int | None = None
        self._lss_answers: deque[Reply] = deque(maxlen=8)

    @property
    def is_polite(self) -> bool:
        """Whether another master is not to be disturbed."""
        return self.network.pace == POLITE_PACE

    @is_polite.setter
    def is_polite(self, polite: bool) -> None:
        self.network.pace = POLITE_PACE if polite else PACE

    def listen(self, seconds: float) -> None:
        """Hear what comes in so many seconds."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0.0:
            self.network.pump(left)

    def sweep(self, nodes: range | list[int]) -> None:
        """Ask nodes for their device type, and have all read that answer."""
        for node in nodes:
            if not (self.is_polite and node in self.traffic.foreign_sdo):
                self.network.send_message(SDO_REQUEST + node, DEVICE_TYPE)
        self.listen(self._timeout)

    def read_due(self, progress: Callable[[int, int], None]) -> None:
        """Read the nodes that were heard and have not been read since."""
        while self._due:
            node = min(self._due)
            self._due.discard(node)
            self._readings[node] = self._read(node)
            progress(len(self._readings), len(self._readings) + len(self._due))

    def lss(self, first_id: int | None) -> tuple[tuple[Identity, ...], dict[int, Identity]]:
        """Return the devices without a node id, and those that got one with that id."""
        master = LssMaster(_LssFrames(self.network, self._lss_answers))
        found: list[Identity] = []
        given: dict[int, Identity] = {}
        while (identity := master.fastscan()) is not None and len(found) < len(NODES):
            found.append(identity)
            free = (node for node in NODES if node not in self._readings and node not in given)
            node = next((node for node in free if node >= (first_id or 0)), None)
            if first_id is None or node is None:
                continue  # it stays in configuration, so that the next scan finds another one
            if master.configure_id(node):
                given[node] = identity
            master.leave()
        master.leave()
        return tuple(found), given

    def nodes(self) -> tuple[NodeReading, ...]:
        """Return all readings in the order of the node ids."""
        return tuple(reading for _, reading in sorted(self._readings.items()))

    def _read(self, node: int) -> NodeReading:
        if self.is_polite and node in self.traffic.foreign_sdo:
            return NodeReading(node, remark=ServerBusyError(node).problem)
        if self.is_polite and self.traffic.states.get(node) == BOOT_UP:
            return NodeReading(node, remark="has just booted; it is left to the other master")
        self._reading = node
        try:
            sdo = self.network.sdo(node, timeout=self._timeout)
            return read_node(sdo) if sdo.answers() else NodeReading(node, remark="does not answer SDO")
        except ServerBusyError as error:
            return NodeReading(node, remark=error.problem)
        finally:
            self._reading = None

    def _take(self, message: can.Message, arrival: float) -> None:
        self.traffic.take(message, arrival)
        function, node = message.arbitration_id & 0x780, message.arbitration_id & 0x7F
        is_boot = function == HEARTBEAT and bytes(message.data) == b"\0"
        if node in self.traffic.nodes and (is_boot or node not in self._readings) and node != self._reading:
            self._due.add(node)
        if message.arbitration_id == SLAVE:
            self._lss_answers.append(Reply(arrival, SLAVE, bytes(message.data)))
        elif function == SDO_REQUEST and node == self._reading and self.is_polite:
            raise ServerBusyError(node)
        elif function == SDO_ANSWER:
            self.network.notify(message.arbitration_id, message.data, message.timestamp)


class _PacedNetwork(BusNetwork):
    """A network that leaves a pause between what it sends, in which it reads."""

    pace = PACE
    _last = float("-inf")

    def send_message(self, can_id: int, data: bytes, remote: bool = False) -> None:
        """Send a frame when its time has come; errors as of `BusNetwork`."""
        while (left := self._last + self.pace - time.monotonic()) > 0.0:
            self.pump(left)
        self._last = time.monotonic()
        super().send_message(can_id, data, remote)


class _Sent:
    """Counts the frames that are sent, by what they are."""

    def __init__(self) -> None:
        self.frames: Counter[str] = Counter()

    def use(self, vehicle: VehicleParameters) -> None:
        """Take a vehicle, of which nothing is needed."""

    def frame(self, _at: float, message: can.Message) -> None:
        """Take a frame that was sent or received."""
        if not message.is_rx:
            self.frames["LSS" if message.arbitration_id == MASTER else "SDO readings"] += 1


class _LssFrames:
    """What an LSS master sends and receives, on a network."""

    def __init__(self, network: BusNetwork, answers: deque[Reply]) -> None:
        self._network, self._answers = network, answers

    def send(self, can_id: int, data: bytes = b"") -> None:
        """Send a frame."""
        self._network.send_message(can_id, data)

    def drain(self) -> None:
        """Forget the answers that have come: several devices may have answered the question before."""
        for _ in range(MOST_DRAINED):
            message = self._network.receive(0.0)
            if message is None:
                break
            self._network.handler(message, self._network.arrival)
        self._answers.clear()

    def await_frame(self, can_id: int, seconds: float | None = None) -> Reply | None:
        """Return the next answer, or None where none comes in time."""
        del can_id
        end = time.monotonic() + (LSS_TIMEOUT if seconds is None else seconds)
        while not self._answers and (left := end - time.monotonic()) > 0.0:
            self._network.pump(left)
        return self._answers.popleft() if self._answers else None
