"""PDOs: packing and unpacking by their mapping, their timing, and their exchange (CiA 301 7.2.2).

The checks of PDO parameters are those of CiA 301 7.5.2.35 to 7.5.2.38.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from omnimate.vcan_sim.errors import Abort, SdoAbort
from omnimate.vcan_sim.nodes.emergency import LENGTH_ERROR, RPDO_TIMEOUT, Emergency

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from omnimate.vcan_sim.nodes.objects import Key, Objects
    from omnimate.vcan_sim.nodes.transmitter import Transmitter

NOT_VALID = 0x8000_0000  # bit 31 of a COB-ID parameter
_EXTENDED = 0x2000_0000  # bit 29: 29-bit identifier
_PDO_BITS = 64
_DUMMIES = {(5, 0): 8, (6, 0): 16, (7, 0): 32}  # dummy entries of an RPDO: data types and their bits

# Restricted COB-IDs, which a PDO must not have: CiA 301 table 41.
_RESTRICTED = (
    range(0x001),
    range(0x001, 0x080),
    range(0x080, 0x081),
    range(0x101, 0x181),
    range(0x581, 0x600),
    range(0x601, 0x680),
    range(0x6E0, 0x800),
)

LAST_SYNCHRONOUS = 240  # largest synchronous transmission type
DEVICE_EVENT = 255  # transmission type of event-driven PDOs
MAPPING = 0x200  # from the index of a PDO's communication parameter to that of its mapping parameter


@dataclass(slots=True, eq=False)
class Tpdo:
    """One TPDO as it is configured at the moment."""

    index: int  # of its communication parameters
    cob_id: int = 0
    valid: bool = False  # whether the PDO is valid and the device operational
    transmission_type: int = DEVICE_EVENT  # sub-index 2
    sync_start: int = 0  # SYNC counter with which transmission begins (sub-index 6); 0 after that or without
    syncs: int = 0  # since the last transmission
    inhibit: float = 0.0  # [s]
    event: float = 0.0  # event timer [s]
    length: int = 0  # [bytes]
    data: bytes | None = None  # data that were sent last; None before the first transmission
    sent: float = -math.inf  # when they were sent [s]
    due: float = math.inf  # when the event timer sends it next, or the inhibit time ends [s]
    _fields: tuple[tuple[Callable[[], int], int, int], ...] = ()

    def configure(self, objects: Objects, now: float, *, operational: bool) -> None:
        """Take over the PDO parameters of the object dictionary; timers restart."""
        cob_id = objects[self.index, 1]
        self.cob_id, self.valid = cob_id & 0x7FF, not cob_id & NOT_VALID
        self.transmission_type = objects[self.index, 2]
        self.inhibit, self.event = objects[self.index, 3] * 1e-4, objects[self.index, 5] * 1e-3
        self.syncs, self.data, self.sent = 0, None, -math.inf
        self.sync_start = objects[self.index, 6]
        entries, self.length = mapped(objects, self.index + MAPPING)
        self._fields = tuple((objects.reader(key), (1 << bits) - 1, shift) for key, bits, shift in entries)
        self.valid = self.valid and operational and self.length > 0
        self.due = now + self.event if self.valid and self.event and not self.synchronous else math.inf

    @property
    def synchronous(self) -> bool:
        """Whether it answers SYNC."""
        return self.transmission_type <= LAST_SYNCHRONOUS

    def pack(self) -> bytes:
        """Return the mapped objects' values now, little-endian."""
        value = 0
        for read, mask, shift in self._fields:
            value |= (read() & mask) << shift
        return value.to_bytes(self.length, "little")

    def was_sent(self, data: bytes, now: float) -> None:
        """Record a transmission and restart the event timer."""
        self.data, self.sent = data, now
        if self.event and not self.synchronous:
            late = now - self.due
            self.due = self.due + self.event if 0.0 <= late < self.event else now + self.event
        else:
            self.due = math.inf

    def may_send(self, now: float) -> bool:
        """Return whether changed data may be sent now; within the inhibit time, set `due` to its end."""
        if now - self.sent >= self.inhibit - 1e-9:
            return True
        self.due = min(self.due, self.sent + self.inhibit)
        return False


@dataclass(slots=True, eq=False)
class Rpdo:
    """One RPDO as it is configured at the moment."""

    index: int  # of its communication parameters
    cob_id: int = 0
    valid: bool = False  # whether the PDO is valid and the device operational
    synchronous: bool = False
    length: int = 0  # [bytes]
    deadline: float = 0.0  # [s]
    due: float = math.inf  # time at which the deadline of the PDO passes [s]
    waiting: bytes | None = None  # data that are applied at the next SYNC; None for none
    _fields: Sequence[tuple[Key, int, int]] = ()

    def configure(self, objects: Objects, *, operational: bool) -> None:
        """Take over the PDO parameters; the deadline starts with the next reception."""
        cob_id = objects[self.index, 1]
        self.cob_id, self.valid = cob_id & 0x7FF, not cob_id & NOT_VALID
        self.synchronous = objects[self.index, 2] <= LAST_SYNCHRONOUS
        self.deadline, self.due, self.waiting = objects[self.index, 5] * 1e-3, math.inf, None
        self._fields, self.length = mapped(objects, self.index + MAPPING)
        self.valid = self.valid and operational and self.length > 0

    def unpack(self, data: bytes) -> list[tuple[Key, bytes]]:
        """Return the mapped objects and their bytes, without dummy entries."""
        return [
            (key, data[shift // 8 : (shift + bits) // 8])
            for key, bits, shift in self._fields
            if key[0] >= 0x1000
        ]


def mapped(objects: Objects, index: int) -> tuple[list[tuple[Key, int, int]], int]:
    """Return (object, length, first bit) [bit] of each entry of a mapping, and the PDO's length [byte]."""
    fields, shift = [], 0
    for sub in range(1, objects[index, 0] + 1):
        entry = objects[index, sub]
        fields.append(((entry >> 16, entry >> 8 & 0xFF), entry & 0xFF, shift))
        shift += entry & 0xFF
    return fields, shift // 8


def check_communication(objects: Objects, index: int, sub: int, value: int) -> None:
    """Refuse a communication parameter (1400h, 1800h) that must not be written; raises SdoAbort."""
    if sub == 1:
        _check_cob_id(objects[index, 1], value)
    elif sub == 2 and 240 < value < 254:
        raise SdoAbort(Abort.VALUE)  # 241 to 251 are reserved; remote frames are not answered
    elif sub == 3 and not objects[index, 1] & NOT_VALID:
        raise SdoAbort(Abort.STATE)


def _check_cob_id(old: int, new: int) -> None:
    if new & _EXTENDED:
        raise SdoAbort(Abort.VALUE)
    if new & NOT_VALID:
        return
    if any(new & 0x7FF in restricted for restricted in _RESTRICTED):
        raise SdoAbort(Abort.VALUE)
    if not old & NOT_VALID and (old ^ new) & 0x1FFF_FFFF:
        raise SdoAbort(Abort.VALUE)


def check_mapping(objects: Objects, index: int, sub: int, value: int, *, pre_operational: bool) -> None:
    """Refuse a write to a mapping (1600h, 1A00h) that is invalid or in the wrong order; raises SdoAbort.

    The order is: pre-operational, COB-ID invalid, number of entries 0, entries, number of entries.
    """
    communication = index - MAPPING
    if not pre_operational or not objects[communication, 1] & NOT_VALID:
        raise SdoAbort(Abort.STATE)
    if sub == 0:
        _check_count(objects, index, value)
    elif objects[index, 0]:
        raise SdoAbort(Abort.STATE)
    else:
        _check_entry(objects, index, value)


def _check_count(objects: Objects, index: int, count: int) -> None:
    entries = [objects[index, sub] for sub in range(1, count + 1)]
    for entry in entries:
        _check_entry(objects, index, entry)
    if sum(entry & 0xFF for entry in entries) > _PDO_BITS:
        raise SdoAbort(Abort.PDO_LENGTH)


def _check_entry(objects: Objects, index: int, entry: int) -> None:
    """Refuse an entry whose object cannot be mapped; a length below its own maps the low bytes."""
    key, bits = (entry >> 16, entry >> 8 & 0xFF), entry & 0xFF
    receives = index < 0x1800
    if receives and _DUMMIES.get(key) == bits:
        return
    variable = objects.variable(key)
    fits = variable.size is not None and 0 < bits <= 8 * variable.size and bits % 8 == 0
    if not (variable.mappable and fits and (variable.writable or not receives)):
        raise SdoAbort(Abort.NOT_MAPPABLE)


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
