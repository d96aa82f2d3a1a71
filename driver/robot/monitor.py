"""Hands every received frame to the part that handles it: PDO, heartbeat, EMCY, SDO, or unknown frame."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.driver.robot.assembler import Assembler
from omnimate.driver.robot.events import EventLog, NodeCounts, Trouble
from omnimate.driver.robot.status_words import StatusWordMonitor
from omnimate.driver.robot.supervision import Supervision
from omnimate.driver.robot.unexpected_frames import FloodDetector, UnknownFrames
from omnimate.files.logs.canopen_words import BOOT_UP, EMCY, HEARTBEAT, SDO_ANSWER, SYNC_ID

if TYPE_CHECKING:
    from collections.abc import Callable

    import can

    from omnimate.driver.bus.clock import Clock
    from omnimate.vehicle.parameters import VehicleParameters

FOREIGN_SYNCS = 3  # SYNCs of another device from which on they are a problem: fewer are a master that ends


class Monitor:
    """Handles all received frames, with the driver or another device as SYNC producer.

    `counts` has frame counters of encoders and drives by node id. `on_sdo` takes an SDO answer: COB-ID, data,
    time [s]; `others` returns whether another master may use an 11-bit identifier.
    """

    def __init__(self, vehicle: VehicleParameters, clock: Clock) -> None:
        self.events = EventLog()
        self.counts = {node: NodeCounts() for node in vehicle.nodes}
        self.assembler = Assembler(vehicle, self.events, self.counts)
        self.supervision = Supervision(self.counts, self.events)
        self.status_words = StatusWordMonitor(self.supervision.troubles, self.events)
        self.unknown = UnknownFrames(self.counts)
        self._flooding = FloodDetector(self.counts, self.events)
        self.on_sdo: Callable[[int, bytearray, float], None] = lambda _can_id, _data, _now: None
        self.others: Callable[[int], bool] = lambda _can_id: False
        self._clock = clock
        self._foreign_syncs = 0
        self._cob_ids = self.assembler.cob_ids

    def begin(self, vehicle: VehicleParameters) -> None:
        """Count from zero again, for the vehicle with the ranges that its devices report."""
        for node in self.counts:
            self.counts[node] = NodeCounts()
        self.assembler = Assembler(vehicle, self.events, self.counts)
        self._cob_ids = self.assembler.cob_ids

    def take(self, message: can.Message, arrival: float) -> None:
        """Take a received frame that was on the bus at `arrival` on the recording's clock [s]."""
        if message.is_extended_id or message.is_remote_frame or message.is_error_frame or message.is_fd:
            self.unknown.count(message)
        elif message.arbitration_id in self._cob_ids:
            self.assembler.frame(message.arbitration_id, message.data, message.timestamp, arrival)
            if message.arbitration_id in self.status_words.fields:
                self.status_words.pdo(message.arbitration_id, message.data, self._clock.now())
        elif not self._take_service(message.arbitration_id, message.data):
            self._flooding.note(message.arbitration_id)
            if not self.others(message.arbitration_id):
                self.unknown.count(message)
            if message.arbitration_id == SYNC_ID and message.is_rx:
                self._foreign_sync()

    def _foreign_sync(self) -> None:
        """Count a SYNC that another device has sent; report `FOREIGN_SYNCS` or more."""
        self._flooding.foreign_sync()
        self._foreign_syncs += 1
        if self._foreign_syncs >= FOREIGN_SYNCS:
            what = "another device produces SYNC, too: switch it off there (bit 30 of its 1005h)"
            self.trouble(what)

    def trouble(self, what: str, node: int | None = None) -> None:
        """Report something that somebody must put right, and that stops the robot."""
        now = self._clock.now()
        self.events.add(now, node, what, is_problem=True)
        self.supervision.troubles.append(Trouble(now, None, what))

    def report_unanswered(self, node: int, advice: str) -> None:
        """Report a node of which no answer has entered a sample, with advice for where none has come."""
        what = f"has never answered SYNC: {advice}"
        if self.assembler.is_late(node):
            what = (
                "answers SYNC too late for every sample: "
                "the SYNC period is too short for it, or this computer or its adapter too slow"
            )
        self.trouble(what, node)

    def synced(self, now: float) -> None:
        """Compare the traffic of each node with the number of SYNCs, once per SYNC at `now` [s]."""
        for node in self._flooding.check(now):
            self.trouble("answers each SYNC twice: two devices have this node id; renumber one", node)

    def pause(self, seconds: float, now: float) -> None:
        """Exclude a time until `now` [s], in which the bus was not read, from the silence of the nodes."""
        self.supervision.pause(seconds, now)
        self.status_words.pause(now)

    def check(self, now: float) -> None:
        """Check heartbeats and status words at `now` [s], as often as possible; raises BusLost."""
        self.supervision.check(now)
        self.status_words.check(now)

    def _take_service(self, can_id: int, data: bytearray) -> bool:
        """Take a frame of a CANopen service of one of the vehicle's nodes; return False where it is none."""
        function, node = can_id & ~0x7F, can_id & 0x7F
        if can_id in self.status_words.fields:
            self._flooding.note(can_id)
            if not self.status_words.pdo(can_id, data, self._clock.now()):
                for owner, _ in self.status_words.fields[can_id]:
                    self.counts[owner].wrong_length += 1
            return True
        if node not in self.counts or function not in {EMCY, SDO_ANSWER, HEARTBEAT}:
            return False
        if not self._serve(function, node, data):
            self.counts[node].wrong_length += 1
        return True

    def _serve(self, function: int, node: int, data: bytearray) -> bool:
        """Hand a frame to its service; return False where its length is impossible."""
        now = self._clock.now()
        if function == SDO_ANSWER:
            if len(data) == 8:
                self.status_words.sdo_answer(node, data, now)
                self.on_sdo(SDO_ANSWER + node, data, now)
            return len(data) == 8
        self._flooding.note(function + node)
        if function == HEARTBEAT:
            if bytes(data) == bytes([BOOT_UP]):
                self.assembler.node_booted(node)
            return self.supervision.heartbeat(node, data, now)
        return self.supervision.emergency(node, data, now)
