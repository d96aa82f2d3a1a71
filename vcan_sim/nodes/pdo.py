"""PDOs: packing and unpacking by their mapping, and timing of TPDOs (CiA 301 7.2.2).

The checks of PDO parameters are those of CiA 301 7.5.2.35 to 7.5.2.38.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from omnimate.vcan_sim.errors import Abort, SdoAbort

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from omnimate.vcan_sim.nodes.objects import Key, Objects

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
