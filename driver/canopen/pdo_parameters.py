"""Reads and writes the parameters of a PDO by SDO, in the order that CiA 301 asks for."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING

from omnimate.driver.canopen.dictionary import PDO_NUMBERS
from omnimate.driver.canopen.pdo_mapping import Entry
from omnimate.driver.errors import MappingImpossible, NotTaken, SdoRefused

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.driver.canopen.sdo import Sdo

TPDO, RPDO = 0x1800, 0x1400  # communication parameters of the first PDO
MAPPING = 0x200  # from communication to mapping parameters
# Upper bits of a PDO's COB-ID (CiA 301, 7.5.2.37): it is switched off; it cannot be requested; 29 bits.
INVALID, NO_RTR, EXTENDED = 1 << 31, 1 << 30, 1 << 29
# SDO abort codes of devices that cannot map an object; CiA 301 asks for the first two
NOT_MAPPABLE = frozenset({0x06020000, 0x06040041, 0x06090011, 0x06090030})
MAX_ENTRIES = 64  # of a mapping: 64 objects of one bit (CiA 301, 7.5.2.38)


@dataclass(frozen=True, slots=True)
class Transmission:
    """When a PDO is sent."""

    type: int  # transmission type, sub-index 2; 1 is on every SYNC, 254 and 255 are at an event
    inhibit: int = 0  # inhibit time, sub-index 3 [100 us]
    timer: int = 0  # event timer, sub-index 5 [ms]


@dataclass(frozen=True, slots=True)
class PdoSetting:
    """The parameters of a PDO as a device has them."""

    base: int  # index of the communication parameters, such as 1801h
    raw: int  # COB-ID with its upper bits, sub-index 1
    transmission: int  # transmission type, sub-index 2; 1 is on every SYNC
    inhibit: int | None  # inhibit time, sub-index 3 [100 us]; None where the device has none
    timer: int | None  # event timer, sub-index 5 [ms]; None where the device has none
    entries: tuple[Entry, ...]  # mapped objects in order

    @property
    def cob_id(self) -> int:
        """The identifier of 11 bits, or that of 29 bits with bit 29 set."""
        return self.raw & (EXTENDED | 0x1FFFFFFF if self.is_extended else 0x7FF)

    @property
    def is_extended(self) -> bool:
        """Whether the identifier has 29 bits; the driver receives no such PDO."""
        return bool(self.raw & EXTENDED)

    @property
    def is_valid(self) -> bool:
        """Whether the PDO is switched on."""
        return not self.raw & INVALID

    @property
    def name(self) -> str:
        """Name such as TPDO1 or RPDO4."""
        return f"{'TPDO' if self.base >= TPDO else 'RPDO'}{(self.base & 0xFF) + 1}"

    def in_words(self) -> str:
        """Return the setting as a line of text."""
        mapped = ", ".join(entry.in_words() for entry in self.entries) or "nothing"
        state = "" if self.is_valid else ", switched off"
        return f"{self.name} {self.cob_id:03X}h type {self.transmission} maps {mapped}{state}"


def read_pdo(sdo: Sdo, base: int) -> PdoSetting | None:
    """Return a PDO of the device, or None where it has none with these communication parameters.

    Raises SdoSilent.
    """
    raw = sdo.find(base, 1)
    if raw is None:
        return None
    mapping = base + MAPPING
    count = min(sdo.find(mapping, 0) or 0, MAX_ENTRIES)
    entries = tuple(Entry.of(sdo.find(mapping, number) or 0) for number in range(1, count + 1))
    return PdoSetting(base, raw, sdo.find(base, 2) or 0, sdo.find(base, 3), sdo.find(base, 5), entries)


def read_pdos(sdo: Sdo, base: int) -> tuple[PdoSetting, ...]:
    """Return the PDOs that the device has among the first four; `base` is TPDO or RPDO; raises SdoSilent."""
    settings = (read_pdo(sdo, base + number) for number in PDO_NUMBERS)
    return tuple(setting for setting in settings if setting is not None)


def write_pdo(
    sdo: Sdo,
    old: PdoSetting,
    cob_id: int,
    choices: Sequence[Transmission],
    slots: Sequence[Sequence[Entry]] | None = None,
) -> PdoSetting:
    """Set a PDO and return it as read back; the node must be pre-operational.

    The order is that of CiA 301: bit 31 set, transmission type, inhibit time and event timer, count 0,
    entries, count, bit 31 cleared. Bit 30 stays as the device had it. Nothing is written that holds already.
    Of `choices` the first that the device takes is used; each of `slots` is a sequence of alternatives, the
    best first, and None leaves the mapping as it is.

    Raises MappingImpossible where the device cannot map what is needed or does not take the COB-ID,
    SdoRefused where it refuses every transmission, NotTaken or SdoSilent.
    """
    is_off = _switch_off_where_possible(sdo, old, cob_id)
    _set_transmission(sdo, old, choices)
    if slots is not None:
        _write_entries(sdo, old.base + MAPPING, slots, old)
    if is_off:
        try:
            sdo.write(old.base, 1, cob_id | old.raw & NO_RTR)
        except SdoRefused as refused:
            raise _cob_id_stays(sdo, old, cob_id) from refused
    written = read_pdo(sdo, old.base)
    if written is None or not written.is_valid or written.cob_id != cob_id:
        raise _cob_id_stays(sdo, old, cob_id)
    if slots is not None and not _maps(written, slots):
        raise _mapping_refused(sdo, old, slots, f"it reads back {written.in_words()}")
    return written


def switch_off(sdo: Sdo, setting: PdoSetting) -> None:
    """Set bit 31 of a PDO's COB-ID; raises SdoRefused or SdoSilent."""
    sdo.write(setting.base, 1, setting.raw | INVALID)


def _switch_off_where_possible(sdo: Sdo, old: PdoSetting, cob_id: int) -> bool:
    """Switch a PDO off; return False where it cannot be, and has its COB-ID already."""
    if not old.is_valid:
        return True
    try:
        switch_off(sdo, old)
    except SdoRefused as refused:
        if old.cob_id == cob_id:
            return False
        raise _cob_id_stays(sdo, old, cob_id) from refused
    return True


def _cob_id_stays(sdo: Sdo, old: PdoSetting, cob_id: int) -> MappingImpossible:
    return MappingImpossible(
        sdo.node,
        f"{old.name} does not take the COB-ID in {old.base:04X}h:01; expected {cob_id:03X}h",
        f"let cob_id in vehicle.toml follow the device, which has {old.cob_id:03X}h",
    )


def _set_transmission(sdo: Sdo, old: PdoSetting, choices: Sequence[Transmission]) -> None:
    """Set the first transmission that the device takes, and its two times where they can be written."""
    for left, choice in zip(reversed(range(len(choices))), choices, strict=True):
        try:
            sdo.put(old.base, 2, choice.type)
        except (SdoRefused, NotTaken):
            if not left:
                raise
            continue
        for subindex, before, value in ((3, old.inhibit, choice.inhibit), (5, old.timer, choice.timer)):
            if before is not None:
                with suppress(SdoRefused, NotTaken):
                    sdo.put(old.base, subindex, value)
        return


def _write_entries(sdo: Sdo, mapping: int, slots: Sequence[Sequence[Entry]], old: PdoSetting) -> None:
    try:
        sdo.put(mapping, 0, 0)
        for number, alternatives in enumerate(slots, start=1):
            _write_entry(sdo, mapping, number, alternatives)
        sdo.put(mapping, 0, len(slots))
    except SdoRefused as refused:
        raise _mapping_refused(sdo, old, slots, refused.problem) from refused


def _maps(setting: PdoSetting, slots: Sequence[Sequence[Entry]]) -> bool:
    return len(setting.entries) == len(slots) and all(
        entry in alternatives for entry, alternatives in zip(setting.entries, slots, strict=True)
    )


def _mapping_refused(
    sdo: Sdo, old: PdoSetting, slots: Sequence[Sequence[Entry]], problem: str
) -> MappingImpossible:
    expected = ", ".join(alternatives[0].in_words() for alternatives in slots)
    return MappingImpossible(
        sdo.node,
        f"{old.name} cannot be mapped as start_bit and bits ask for ({problem}); expected {expected}, the "
        f"device has {old.in_words()}",
        "let vehicle.toml follow the device, or use another PDO",
    )


def _write_entry(sdo: Sdo, mapping: int, number: int, alternatives: Sequence[Entry]) -> None:
    for left, entry in zip(reversed(range(len(alternatives))), alternatives, strict=True):
        try:
            sdo.put(mapping, number, entry.value)
        except SdoRefused as refused:
            if not left or refused.abort_code not in NOT_MAPPABLE:
                raise
        else:
            return
