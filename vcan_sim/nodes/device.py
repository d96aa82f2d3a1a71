"""A CANopen device: object dictionary and services of one node (CiA 301), and its LSS slave (CiA 305)."""

from __future__ import annotations

import math
from enum import IntEnum
from functools import partial
from typing import TYPE_CHECKING

from omnimate.vcan_sim.errors import Abort
from omnimate.vcan_sim.nodes.emergency import HEARTBEAT_ERROR, SYNC_LENGTH, Emergency
from omnimate.vcan_sim.nodes.exchange import PdoExchange
from omnimate.vcan_sim.nodes.heartbeat import HeartbeatConsumer, HeartbeatProducer, NodeGuarding
from omnimate.vcan_sim.nodes.lss import SLAVE, UNCONFIGURED, LssSlave
from omnimate.vcan_sim.nodes.objects import refuse_unless
from omnimate.vcan_sim.nodes.sdo import SdoServer
from omnimate.vcan_sim.nodes.transmitter import Transmitter

if TYPE_CHECKING:
    from collections.abc import Callable

    from omnimate.vcan_sim.nodes.objects import Objects
    from omnimate.vcan_sim.nodes.pdo import Rpdo
    from omnimate.vcan_sim.nodes.transmitter import Disturbance

SYNC_ID = 0x080
_LAST_COMMUNICATION_OBJECT, _LAST_OBJECT = 0x1FFF, 0xFFFF
_SAVE, _LOAD = int.from_bytes(b"save", "little"), int.from_bytes(b"load", "little")  # 1010h, 1011h


class NmtState(IntEnum):
    """The states of CiA 301 figure 48, as the heartbeat reports them."""

    STOPPED = 0x04
    OPERATIONAL = 0x05
    PRE_OPERATIONAL = 0x7F


_COMMANDS = {0x01: NmtState.OPERATIONAL, 0x02: NmtState.STOPPED, 0x80: NmtState.PRE_OPERATIONAL}


class Device:
    """One node of the bus; subclasses for profiles add readers, checks and reactions to `objects`."""

    def __init__(self, objects: Objects, send: Callable[[int, bytes], None]) -> None:
        self.objects = objects
        self.now = 0.0  # on the device's clock [s]
        self.due = math.inf  # when the next of its timers ends [s]
        self.state = NmtState.PRE_OPERATIONAL
        self.transmitter = Transmitter(send)  # where its faults act
        self.emergency = Emergency(lambda data: self.transmitter.send(self.objects[0x1014, 0], data))
        self._sdo = SdoServer(self.objects.read, self.objects.write, self.objects.size)
        self._producer = HeartbeatProducer()
        self._consumer = HeartbeatConsumer()
        self._guarding = NodeGuarding()
        self.lss = LssSlave(
            self.node, self._identity, lambda data: self.transmitter.send(SLAVE, data), self._boot_with_new_id
        )
        self._exchange = PdoExchange(self.objects, self.transmitter, self.emergency, self.master_lost)
        self._add_communication_objects()

    def _add_communication_objects(self) -> None:
        objects = self.objects
        objects.readers[0x1001, 0] = lambda: self.emergency.register
        objects.readers |= {(0x1003, sub): partial(self.emergency.history, sub) for sub in range(9)}
        objects.checks[0x1003] = lambda _sub, value: self.emergency.erase_history(value)
        objects.checks[0x1005] = refuse_unless(lambda value: value & 0x3FFF_FFFF == SYNC_ID)
        objects.checks[0x1010] = refuse_unless(lambda value: value == _SAVE, Abort.NOT_STORED)
        objects.checks[0x1011] = refuse_unless(lambda value: value == _LOAD, Abort.NOT_STORED)
        objects.checks[0x1019] = refuse_unless(lambda value: value == 0 or 2 <= value <= 240)
        objects.readers |= {(index, 1): lambda: 1 for index in (0x1010, 0x1011)}  # on command
        objects.reactions[0x100C] = objects.reactions[0x100D] = lambda _sub, _value: self._guard()
        objects.reactions[0x1010] = lambda _sub, _value: self.objects.store()
        objects.reactions[0x1011] = lambda _sub, _value: self.objects.forget_stored()
        objects.reactions[0x1016] = lambda _sub, value: self._consumer.configure(value)
        objects.reactions[0x1017] = lambda _sub, value: self._producer.configure(value, self.now)
        for index in self._exchange.indices:
            objects.checks[index] = partial(self._check_pdo, index)
            objects.reactions[index] = lambda _sub, _value: self.configure_pdos()

    @property
    def node(self) -> int:
        """Node id of the device."""
        return self.objects.node

    @property
    def rpdos(self) -> tuple[Rpdo, ...]:
        """The PDOs that the device receives."""
        return self._exchange.rpdos

    def _check_pdo(self, index: int, sub: int, value: int) -> None:
        pre_operational = self.state is NmtState.PRE_OPERATIONAL
        self._exchange.check(index, sub, value, pre_operational=pre_operational)

    def configure_pdos(self) -> None:
        """Configure the PDOs by the object dictionary and the NMT state."""
        self._exchange.configure(self.now, operational=self.state is NmtState.OPERATIONAL)

    def _guard(self) -> None:
        self._guarding.configure(self.objects[0x100C, 0], self.objects[0x100D, 0])

    def _identity(self) -> tuple[int, ...]:
        return tuple(self.objects[0x1018, sub] for sub in range(1, 5))

    @property
    def _is_inactive(self) -> bool:
        """Whether it ignores the bus, because it has no power or no node id."""
        return self.transmitter.disturbance.off or self.node == UNCONFIGURED

    # What a profile adds

    def reset_application(self) -> None:
        """Reset the profile's state outside the object dictionary to that after power-on."""

    def master_lost(self) -> None:
        """React to the loss of the master's heartbeat or RPDOs, or to the end of the operational state."""

    # NMT

    def boot(self, now: float) -> None:
        """Start with all objects at their defaults: send the boot-up message, enter pre-operational."""
        self.now = now
        self._restart(_LAST_OBJECT)

    def reset(self, now: float) -> None:
        """Reset and boot, as by NMT reset node or at power-on."""
        self.reset_application()
        self.boot(now)

    def switch_off(self, now: float) -> None:
        """Switch the power off; `reset` is the power-on."""
        self.now = now
        self.reset_application()
        self.lss.pending = self.lss.stored
        self._deactivate()

    def _deactivate(self) -> None:
        self._enter(NmtState.STOPPED)
        self._producer.configure(0, self.now)
        self._consumer.configure(0)
        self._guarding.reset()
        self._reschedule()

    def _restart(self, last_index: int) -> None:
        self._sdo.reset()
        self.emergency.reset()
        self.objects.reset(last_index)
        if self.lss.pending != self.node:
            self.objects.assign(self.lss.pending)
            self.lss.active = self.lss.pending
            self.objects.reset(last_index)
        if self.node == UNCONFIGURED:
            self._deactivate()
            return
        self._producer.configure(self.objects[0x1017, 0], self.now)
        self._consumer.configure(self.objects[0x1016, 1])
        self._guarding.reset()
        self._guard()
        self.transmitter.send(0x700 + self.node, b"\0")
        self._enter(NmtState.PRE_OPERATIONAL)

    def _boot_with_new_id(self) -> None:
        """Boot after LSS has assigned a node id to a device that had none."""
        self._restart(_LAST_COMMUNICATION_OBJECT)

    def _enter(self, state: NmtState) -> None:
        if self.state is NmtState.OPERATIONAL and state is not NmtState.OPERATIONAL:
            self.master_lost()
        self.state = state
        self.configure_pdos()
        self._reschedule()

    def on_nmt(self, command: int, now: float) -> None:
        """Execute an NMT command; unknown ones are ignored."""
        self.now = now
        if self._is_inactive:
            return
        if command == 0x81:
            self.reset(now)
        elif command == 0x82:
            self._enter(NmtState.STOPPED)
            self._restart(_LAST_COMMUNICATION_OBJECT)
        elif command in _COMMANDS and _COMMANDS[command] is not self.state:
            self._enter(_COMMANDS[command])
        self._after_input()

    # Frames and time

    def on_sdo(self, request: bytes, now: float) -> None:
        """Answer an SDO request, unless stopped."""
        self.now = now
        if self.state is NmtState.STOPPED:
            return
        for answer in self._sdo.answers(request):
            self.transmitter.send(0x580 + self.node, answer)
        self._after_input()

    def on_lss(self, data: bytes, now: float) -> None:
        """Process a message of the LSS master."""
        self.now = now
        if not self.transmitter.disturbance.off:
            self.lss.receive(data)
            self._reschedule()

    def on_remote(self, can_id: int, now: float) -> None:
        """Answer node guarding if the device has no heartbeat; other remote frames are not answered."""
        self.now = now
        if can_id == 0x700 + self.node and not self._is_inactive and self._producer.due == math.inf:
            self.emergency.clear(HEARTBEAT_ERROR)
            self.transmitter.send(can_id, self._guarding.answer(self.state, now))
            self._reschedule()

    def on_rpdo(self, rpdo: Rpdo, data: bytes, now: float) -> None:
        """Process one of the device's RPDOs."""
        self.now = now
        if not self._is_inactive:
            self._exchange.receive(rpdo, data, now)
            self._after_input()

    def on_heartbeat(self, node: int, now: float) -> None:
        """Receive the heartbeat of another node."""
        self.now = now
        if not self._is_inactive and self._consumer.receive(node, now):
            self.emergency.clear(HEARTBEAT_ERROR)
            self._reschedule()

    def on_sync(self, now: float, data: bytes = b"") -> None:
        """Process SYNC, whose data may have a counter: send the synchronous PDOs."""
        self.now = now
        if data or self.objects[0x1019, 0]:
            self._check_sync(data)
        self._exchange.on_sync(now, data[0] if data else None)
        self.due = min(self.due, self._exchange.due, self.transmitter.due)

    def disturb(self, disturbance: Disturbance, now: float) -> None:
        """Change the faults of the device."""
        self.now = now
        self.transmitter.disturb(disturbance, now)
        self._reschedule()

    def run_timers(self, now: float) -> None:
        """Run the timers that have ended [s]: heartbeat, event timers, deadlines, delayed frames."""
        self.now = now
        if now >= self._producer.due:
            self._producer.sent(now)
            self.transmitter.send(0x700 + self.node, bytes([self.state]))
        if now >= min(self._consumer.due, self._guarding.due):
            self._consumer.due = self._guarding.due = math.inf
            self.emergency.set(HEARTBEAT_ERROR)
            self.master_lost()
            self._change_state_after_error()
        self._exchange.run_timers(now)
        self.transmitter.run(now)
        self._after_input()

    def _change_state_after_error(self) -> None:
        """Change the NMT state after a communication error by 1029h:1."""
        behaviour = self.objects[0x1029, 1]
        if behaviour == 0 and self.state is NmtState.OPERATIONAL:
            self._enter(NmtState.PRE_OPERATIONAL)
        elif behaviour == 2 and self.state is not NmtState.STOPPED:
            self._enter(NmtState.STOPPED)

    def _check_sync(self, data: bytes) -> None:
        """Report by EMCY a SYNC with a counter if 1019h is 0, or without one if it is not 0."""
        if len(data) == (1 if self.objects[0x1019, 0] else 0):
            self.emergency.clear(SYNC_LENGTH)
        else:
            self.emergency.set(SYNC_LENGTH)

    def _after_input(self) -> None:
        """Send event-driven PDOs whose data have changed, and find the next timer."""
        self._exchange.send_events(self.now)
        self._reschedule()

    def _reschedule(self) -> None:
        watched = min(self._consumer.due, self._guarding.due)
        self.due = min(self._producer.due, watched, self._exchange.due, self.transmitter.due)
