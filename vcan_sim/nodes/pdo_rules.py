"""What a device allows to be written to its PDO parameters, and when (CiA 301 7.5.2.35 to 7.5.2.38)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.vcan_sim.errors import SdoAbort
from omnimate.vcan_sim.nodes.abort import Abort

if TYPE_CHECKING:
    from omnimate.vcan_sim.nodes.dictionary import ObjectStore

NOT_VALID = 0x8000_0000
_EXTENDED = 0x2000_0000
_PDO_BITS = 64
_DUMMIES = {(5, 0): 8, (6, 0): 16, (7, 0): 32}  # data types that an RPDO may be filled up with

# COB-IDs that CiA 301 table 41 keeps from PDOs.
_RESTRICTED = (
    range(0x001),
    range(0x001, 0x080),
    range(0x080, 0x081),
    range(0x101, 0x181),
    range(0x581, 0x600),
    range(0x601, 0x680),
    range(0x6E0, 0x800),
)


def check_communication(store: ObjectStore, index: int, sub: int, value: int) -> None:
    """Refuse a communication parameter (1400h, 1800h) that must not be written; raises SdoAbort."""
    if sub == 1:
        _check_cob_id(store[index, 1], value)
    elif sub == 2 and 240 < value < 254:
        raise SdoAbort(Abort.VALUE)  # 241 to 251 are reserved; remote frames are not answered
    elif sub == 3 and not store[index, 1] & NOT_VALID:
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


def check_mapping(store: ObjectStore, index: int, sub: int, value: int, *, pre_operational: bool) -> None:
    """Refuse a mapping (1600h, 1A00h) that breaks the order or cannot be carried; raises SdoAbort.

    The order: pre-operational, COB-ID invalid, number of entries 0, entries, number of entries.
    """
    communication = index - 0x200
    if not pre_operational or not store[communication, 1] & NOT_VALID:
        raise SdoAbort(Abort.STATE)
    if sub == 0:
        _check_count(store, index, value)
    elif store[index, 0]:
        raise SdoAbort(Abort.STATE)
    else:
        _check_entry(store, index, value)


def _check_count(store: ObjectStore, index: int, count: int) -> None:
    entries = [store[index, sub] for sub in range(1, count + 1)]
    for entry in entries:
        _check_entry(store, index, entry)
    if sum(entry & 0xFF for entry in entries) > _PDO_BITS:
        raise SdoAbort(Abort.PDO_LENGTH)


def _check_entry(store: ObjectStore, index: int, entry: int) -> None:
    """Refuse an entry whose object cannot be mapped; a shorter length than its own carries the low bytes."""
    key, bits = (entry >> 16, entry >> 8 & 0xFF), entry & 0xFF
    receives = index < 0x1800
    if receives and _DUMMIES.get(key) == bits:
        return
    variable = store.variable(key)
    fits = variable.size is not None and 0 < bits <= 8 * variable.size and bits % 8 == 0
    if not (variable.mappable and fits and (variable.writable or not receives)):
        raise SdoAbort(Abort.NOT_MAPPABLE)
