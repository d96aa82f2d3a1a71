"""The PDO exchange of a device: what it sends on SYNC, on events and by timer, and what it receives."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from vcan_sim.errors import SdoAbort
from vcan_sim.nodes import emergency, pdo_rules
from vcan_sim.nodes.pdo import DEVICE_EVENT, Rpdo, Tpdo

if TYPE_CHECKING:
    from vcan_sim.nodes.device import Device


class PdoExchange:
    """All PDOs of one device.

    Attributes:
        tpdos: in the order of their index.
        rpdos: likewise.
        due: when a timer of one of them ends [s].
    """

    def __init__(self, device: Device) -> None:
        self._device = device
        store = device.store
        self.tpdos = tuple(Tpdo(index) for index in range(0x1800, 0x1A00) if (index, 1) in store)
        self.rpdos = tuple(Rpdo(index) for index in range(0x1400, 0x1600) if (index, 1) in store)
        self._answers: tuple[Tpdo, ...] = ()
        self._events: tuple[Tpdo, ...] = ()
        self._held: tuple[Rpdo, ...] = ()
        self.due = math.inf

    def check(self, index: int, sub: int, value: int, *, pre_operational: bool) -> None:
        """Refuse a PDO parameter that must not be written now; raises SdoAbort."""
        if index & 0x0200:
            pdo_rules.check_mapping(self._device.store, index, sub, value, pre_operational=pre_operational)
        else:
            pdo_rules.check_communication(self._device.store, index, sub, value)

    def configure(self, now: float, *, operational: bool) -> None:
        """Take over the object dictionary and the NMT state; all timers start anew."""
        for tpdo in self.tpdos:
            tpdo.configure(self._device.store, self._device.reader, now, operational=operational)
        for rpdo in self.rpdos:
            rpdo.configure(self._device.store, operational=operational)
        valid = [tpdo for tpdo in self.tpdos if tpdo.valid]
        self._answers = tuple(tpdo for tpdo in valid if tpdo.synchronous and tpdo.kind)
        self._events = tuple(tpdo for tpdo in valid if tpdo.kind in {0, DEVICE_EVENT})
        self._held = tuple(rpdo for rpdo in self.rpdos if rpdo.synchronous)
        self._reschedule()

    def on_sync(self, now: float) -> None:
        """Answer SYNC: the hot path of the simulation."""
        for rpdo in self._held:
            if rpdo.waiting is not None:
                self._apply(rpdo, rpdo.waiting)
                rpdo.waiting = None
        for tpdo in self._answers:
            tpdo.syncs += 1
            if tpdo.syncs >= tpdo.kind:
                tpdo.syncs = 0
                self._device.transmitter.send_pdo(tpdo.cob_id, tpdo.pack(), now)
        if self._events:
            self.send_events(now, on_sync=True)

    def send_events(self, now: float, *, on_sync: bool = False) -> None:
        """Send event-driven PDOs whose data have changed; those of type 0 only with SYNC."""
        for tpdo in self._events:
            if (tpdo.kind or on_sync) and tpdo.pack() != tpdo.data:
                if tpdo.may_send(now):
                    self._transmit(tpdo, now)
                self._reschedule()

    def receive(self, rpdo: Rpdo, data: bytes, now: float) -> None:
        """Take an RPDO in, at once or with the next SYNC; a wrong length is refused with EMCY 8210h."""
        if len(data) != rpdo.length:
            self._device.emergency.set(emergency.LENGTH_ERROR)
            return
        self._device.emergency.clear(emergency.LENGTH_ERROR)
        self._device.emergency.clear(emergency.RPDO_TIMEOUT)
        rpdo.due = now + rpdo.deadline if rpdo.deadline else math.inf
        if rpdo.synchronous:
            rpdo.waiting = data
        else:
            self._apply(rpdo, data)
        self._reschedule()

    def _apply(self, rpdo: Rpdo, data: bytes) -> None:
        for (index, sub), value in rpdo.unpack(data):
            try:
                self._device.write(index, sub, value)
            except SdoAbort:  # a value out of range leaves the object as it was
                continue

    def run_timers(self, now: float) -> None:
        """Send what an event timer or the end of an inhibit time wants sent; watch the RPDOs' deadlines."""
        for tpdo in self.tpdos:
            if now >= tpdo.due:
                self._transmit(tpdo, now)
        for rpdo in self.rpdos:
            if now >= rpdo.due:
                rpdo.due = math.inf
                self._device.emergency.set(emergency.RPDO_TIMEOUT)
                self._device.master_lost()
        self._reschedule()

    def _transmit(self, tpdo: Tpdo, now: float) -> None:
        data = tpdo.pack()
        tpdo.was_sent(data, now)
        self._device.transmitter.send_pdo(tpdo.cob_id, data, now)

    def _reschedule(self) -> None:
        dues = [tpdo.due for tpdo in self.tpdos] + [rpdo.due for rpdo in self.rpdos]
        self.due = min(dues, default=math.inf)
