"""Reads and writes a PDO of a device by SDO, in the order that CiA 301 asks for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from driver.dictionary import PDO_NUMBERS
from driver.errors import MappingImpossible, SdoRefused
from driver.mapping import Entry

if TYPE_CHECKING:
    from collections.abc import Sequence

    from driver.sdo import Sdo

TPDO, RPDO = 0x1800, 0x1400
MAPPING = 0x200  # from communication to mapping parameters
INVALID = 1 << 31
NO_RTR = 1 << 30
NOT_MAPPABLE = frozenset({0x06020000, 0x06040041, 0x06090011, 0x06090030})
MAX_ENTRIES = 64


@dataclass(frozen=True, slots=True)
class PdoSetting:
    """A PDO as a device has it.

    Attributes:
        base: index of its communication parameters, such as 1801h.
        raw: COB-ID with its upper bits.
        transmission: type; 1 is on every SYNC.
        inhibit: [100 us]; None where the device has none.
        timer: event timer [ms]; None where the device has none.
        entries: mapped objects.
    """

    base: int
    raw: int
    transmission: int
    inhibit: int | None
    timer: int | None
    entries: tuple[Entry, ...]

    @property
    def cob_id(self) -> int:
        """The identifier alone."""
        return self.raw & 0x7FF

    @property
    def is_valid(self) -> bool:
        """Whether the PDO is switched on."""
        return not self.raw & INVALID

    @property
    def name(self) -> str:
        """TPDO1 to TPDO4, RPDO1 to RPDO4."""
        return f"{'TPDO' if self.base >= TPDO else 'RPDO'}{(self.base & 0xFF) + 1}"

    def in_words(self) -> str:
        """Return it as found."""
        mapped = ", ".join(entry.in_words() for entry in self.entries) or "nothing"
        state = "" if self.is_valid else ", switched off"
        return f"{self.name} {self.cob_id:03X}h type {self.transmission} maps {mapped}{state}"


def read_pdo(sdo: Sdo, base: int) -> PdoSetting | None:
    """Return a PDO of the device, or None where it has none at this index.

    Raises:
        SdoRefused, SdoSilent: the dialogue failed.
    """
    raw = sdo.find(base, 1)
    if raw is None:
        return None
    mapping = base + MAPPING
    count = min(sdo.find(mapping, 0) or 0, MAX_ENTRIES)
    entries = tuple(Entry.of(sdo.find(mapping, number) or 0) for number in range(1, count + 1))
    return PdoSetting(base, raw, sdo.find(base, 2) or 0, sdo.find(base, 3), sdo.find(base, 5), entries)


def read_pdos(sdo: Sdo, base: int) -> tuple[PdoSetting, ...]:
    """Return the PDOs that the device has among the first four.

    Raises:
        SdoRefused, SdoSilent: the dialogue failed.
    """
    found = (read_pdo(sdo, base + number) for number in PDO_NUMBERS)
    return tuple(setting for setting in found if setting is not None)


def write_pdo(
    sdo: Sdo, old: PdoSetting, cob_id: int, transmission: int, slots: Sequence[Sequence[Entry]]
) -> PdoSetting:
    """Map a PDO anew and return it as read back; the node must be pre-operational.

    Bit 31 set, transmission type, inhibit time and event timer 0, count 0, entries, count, bit 31 cleared;
    bit 30 stays as the device had it.

    Raises:
        MappingImpossible: the device cannot map what is needed.
        NotTaken, SdoRefused, SdoSilent: the dialogue failed.
    """
    base, mapping = old.base, old.base + MAPPING
    sdo.write(base, 1, old.raw | INVALID)
    sdo.put(base, 2, transmission)
    for subindex, value in ((3, old.inhibit), (5, old.timer)):
        if value:
            sdo.put(base, subindex, 0)
    _write_entries(sdo, mapping, slots, old)
    sdo.write(base, 1, cob_id | old.raw & NO_RTR)
    written = read_pdo(sdo, base)
    if written is None or not written.is_valid or written.cob_id != cob_id:
        raise MappingImpossible(sdo.node, f"{old.name} does not keep its COB-ID {cob_id:03X}h")
    return written


def switch_off(sdo: Sdo, setting: PdoSetting) -> None:
    """Set bit 31 of a PDO.

    Raises:
        SdoRefused, SdoSilent: the dialogue failed.
    """
    sdo.write(setting.base, 1, setting.raw | INVALID)


def _write_entries(sdo: Sdo, mapping: int, slots: Sequence[Sequence[Entry]], old: PdoSetting) -> None:
    try:
        sdo.write(mapping, 0, 0)
        for number, alternatives in enumerate(slots, start=1):
            _write_entry(sdo, mapping, number, alternatives)
        sdo.put(mapping, 0, len(slots))
    except SdoRefused as refused:
        raise MappingImpossible(
            sdo.node,
            f"{old.name} cannot be mapped as start_bit and bits ask for ({refused}); the device has it as: "
            f"{old.in_words()}: let vehicle.toml follow that, or use another PDO",
        ) from refused


def _write_entry(sdo: Sdo, mapping: int, number: int, alternatives: Sequence[Entry]) -> None:
    for left, entry in zip(reversed(range(len(alternatives))), alternatives, strict=True):
        try:
            sdo.put(mapping, number, entry.value)
        except SdoRefused as refused:
            if not left or refused.abort_code not in NOT_MAPPABLE:
                raise
        else:
            return
