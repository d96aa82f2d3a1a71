"""The PDO exchange of a device: transmission on SYNC, on events and by timer, and reception."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from omnimate.vcan_sim.errors import SdoAbort
from omnimate.vcan_sim.nodes.emergency import LENGTH_ERROR, RPDO_TIMEOUT, Emergency
from omnimate.vcan_sim.nodes.pdo import DEVICE_EVENT, MAPPING, Rpdo, Tpdo, check_communication, check_mapping

if TYPE_CHECKING:
    from collections.abc import Callable

    from omnimate.vcan_sim.nodes.objects import Objects
    from omnimate.vcan_sim.nodes.transmitter import Transmitter


class PdoExchange:
    """All PDOs of one device, in the order of their index; the next timer of one ends at `due` [s].

    `indices` are those of the communication and mapping parameters.
    """

    def __init__(
        self,
        objects: Objects,
        transmitter: Transmitter,
        emergency: Emergency,
        on_timeout: Callable[[], None],
    ) -> None:
        """Find the PDOs that the object dictionary declares; `on_timeout` is called at a missed deadline."""
        self._objects = objects
        self._transmitter, self._emergency, self._on_timeout = transmitter, emergency, on_timeout
        self.tpdos = tuple(Tpdo(index) for index in range(0x1800, 0x1A00) if (index, 1) in self._objects)
        self.rpdos = tuple(Rpdo(index) for index in range(0x1400, 0x1600) if (index, 1) in self._objects)
        parameters = [tpdo.index for tpdo in self.tpdos] + [rpdo.index for rpdo in self.rpdos]
        self.indices = (*parameters, *(index + MAPPING for index in parameters))
        self._synchronous_tpdos: tuple[Tpdo, ...] = ()
        self._event_tpdos: tuple[Tpdo, ...] = ()
        self._synchronous_rpdos: tuple[Rpdo, ...] = ()
        self.due = math.inf

    def check(self, index: int, sub: int, value: int, *, pre_operational: bool) -> None:
        """Refuse a PDO parameter that must not be written now; raises SdoAbort."""
        if index & MAPPING:
            check_mapping(self._objects, index, sub, value, pre_operational=pre_operational)
        else:
            check_communication(self._objects, index, sub, value)

    def configure(self, now: float, *, operational: bool) -> None:
        """Configure all PDOs by the object dictionary and the NMT state; all timers restart."""
        for tpdo in self.tpdos:
            tpdo.configure(self._objects, now, operational=operational)
        for rpdo in self.rpdos:
            rpdo.configure(self._objects, operational=operational)
        valid = [tpdo for tpdo in self.tpdos if tpdo.valid]
        self._synchronous_tpdos = tuple(tpdo for tpdo in valid if tpdo.synchronous and tpdo.transmission_type)
        self._event_tpdos = tuple(tpdo for tpdo in valid if tpdo.transmission_type in {0, DEVICE_EVENT})
        self._synchronous_rpdos = tuple(rpdo for rpdo in self.rpdos if rpdo.synchronous)
        self._reschedule()

    def on_sync(self, now: float, counter: int | None = None) -> None:
        """Apply synchronous RPDOs and send synchronous TPDOs; `counter` is that of SYNC, None without one."""
        for rpdo in self._synchronous_rpdos:
            if rpdo.waiting is not None:
                self._apply(rpdo, rpdo.waiting)
                rpdo.waiting = None
        for tpdo in self._synchronous_tpdos:
            if tpdo.sync_start and counter is not None:
                if counter != tpdo.sync_start:
                    continue
                tpdo.sync_start, tpdo.syncs = 0, tpdo.transmission_type - 1
            tpdo.syncs += 1
            if tpdo.syncs >= tpdo.transmission_type:
                tpdo.syncs = 0
                self._transmitter.send_pdo(tpdo.cob_id, tpdo.pack(), now)
        if self._event_tpdos:
            self.send_events(now, on_sync=True)

    def send_events(self, now: float, *, on_sync: bool = False) -> None:
        """Send event-driven PDOs whose data have changed; those of type 0 only with SYNC."""
        for tpdo in self._event_tpdos:
            if (tpdo.transmission_type or on_sync) and tpdo.pack() != tpdo.data:
                if tpdo.may_send(now):
                    self._transmit(tpdo, now)
                self._reschedule()

    def receive(self, rpdo: Rpdo, data: bytes, now: float) -> None:
        """Apply an RPDO, at once or with the next SYNC; a wrong length is refused with EMCY 8210h."""
        if len(data) != rpdo.length:
            self._emergency.set(LENGTH_ERROR)
            return
        self._emergency.clear(LENGTH_ERROR)
        self._emergency.clear(RPDO_TIMEOUT)
        rpdo.due = now + rpdo.deadline if rpdo.deadline else math.inf
        if rpdo.synchronous:
            rpdo.waiting = data
        else:
            self._apply(rpdo, data)
        self._reschedule()

    def _apply(self, rpdo: Rpdo, data: bytes) -> None:
        for (index, sub), value in rpdo.unpack(data):
            try:
                self._objects.write(index, sub, value)
            except SdoAbort:  # a value out of range leaves the object as it was
                continue

    def run_timers(self, now: float) -> None:
        """Send PDOs whose event timer or inhibit time has ended, and check the deadlines of RPDOs."""
        for tpdo in self.tpdos:
            if now >= tpdo.due:
                self._transmit(tpdo, now)
        for rpdo in self.rpdos:
            if now >= rpdo.due:
                rpdo.due = math.inf
                self._emergency.set(RPDO_TIMEOUT)
                self._on_timeout()
        self._reschedule()

    def _transmit(self, tpdo: Tpdo, now: float) -> None:
        data = tpdo.pack()
        tpdo.was_sent(data, now)
        self._transmitter.send_pdo(tpdo.cob_id, data, now)

    def _reschedule(self) -> None:
        dues = [tpdo.due for tpdo in self.tpdos] + [rpdo.due for rpdo in self.rpdos]
        self.due = min(dues, default=math.inf)
