"""Reads and writes the parameters of a PDO by SDO, in the order that CiA 301 asks for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from omnimate.driver.dictionary import PDO_NUMBERS
from omnimate.driver.errors import MappingImpossible, SdoRefused
from omnimate.driver.pdo_mapping import Entry

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.driver.sdo import Sdo

TPDO, RPDO = 0x1800, 0x1400  # communication parameters of the first PDO
MAPPING = 0x200  # from communication to mapping parameters
INVALID = 1 << 31
NO_RTR = 1 << 30
NOT_MAPPABLE = frozenset({0x06020000, 0x06040041, 0x06090011, 0x06090030})  # SDO abort codes
MAX_ENTRIES = 64


@dataclass(frozen=True, slots=True)
class PdoSetting:
    """The parameters of a PDO as a device has them.

    Attributes:
        base: Index of the communication parameters, such as 1801h.
        raw: COB-ID with its upper bits, sub-index 1.
        transmission: Transmission type, sub-index 2; 1 is on every SYNC.
        inhibit: Inhibit time, sub-index 3 [100 us]; None where the device has none.
        timer: Event timer, sub-index 5 [ms]; None where the device has none.
        entries: Mapped objects in order.
    """

    base: int
    raw: int
    transmission: int
    inhibit: int | None
    timer: int | None
    entries: tuple[Entry, ...]

    @property
    def cob_id(self) -> int:
        """The 11-bit identifier without the upper bits."""
        return self.raw & 0x7FF

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

    Raises:
        SdoRefused: The node aborts a transfer for another reason than a missing object.
        SdoSilent: The node stops answering.
    """
    raw = sdo.find(base, 1)
    if raw is None:
        return None
    mapping = base + MAPPING
    count = min(sdo.find(mapping, 0) or 0, MAX_ENTRIES)
    entries = tuple(Entry.of(sdo.find(mapping, number) or 0) for number in range(1, count + 1))
    return PdoSetting(base, raw, sdo.find(base, 2) or 0, sdo.find(base, 3), sdo.find(base, 5), entries)


def read_pdos(sdo: Sdo, base: int) -> tuple[PdoSetting, ...]:
    """Return the PDOs that the device has among the first four; `base` is TPDO or RPDO.

    Raises:
        SdoRefused: The node aborts a transfer for another reason than a missing object.
        SdoSilent: The node stops answering.
    """
    settings = (read_pdo(sdo, base + number) for number in PDO_NUMBERS)
    return tuple(setting for setting in settings if setting is not None)


def write_pdo(
    sdo: Sdo, old: PdoSetting, cob_id: int, transmission: int, slots: Sequence[Sequence[Entry]]
) -> PdoSetting:
    """Map a PDO anew and return it as read back; the node must be pre-operational.

    The order is that of CiA 301: bit 31 set, transmission type, inhibit time and event timer 0, count 0,
    entries, count, bit 31 cleared. Bit 30 stays as the device had it.

    Args:
        sdo: Objects of the node.
        old: PDO as it is.
        cob_id: New COB-ID.
        transmission: New transmission type.
        slots: Entries to map in order; each is a sequence of alternatives, the best first.

    Raises:
        MappingImpossible: The device cannot map what is needed.
        NotTaken: The node confirmed a value and kept another one.
        SdoRefused: The node aborts a transfer.
        SdoSilent: The node stops answering.
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
        raise MappingImpossible(
            sdo.node,
            f"{old.name} does not keep its COB-ID in {base:04X}h:01; expected {cob_id:03X}h",
            f"let cob_id in vehicle.toml follow the device, which has {old.cob_id:03X}h",
        )
    return written


def switch_off(sdo: Sdo, setting: PdoSetting) -> None:
    """Set bit 31 of a PDO's COB-ID.

    Raises:
        SdoRefused: The node aborts the transfer.
        SdoSilent: The node stops answering.
    """
    sdo.write(setting.base, 1, setting.raw | INVALID)


def _write_entries(sdo: Sdo, mapping: int, slots: Sequence[Sequence[Entry]], old: PdoSetting) -> None:
    try:
        sdo.write(mapping, 0, 0)
        for number, alternatives in enumerate(slots, start=1):
            _write_entry(sdo, mapping, number, alternatives)
        sdo.put(mapping, 0, len(slots))
    except SdoRefused as refused:
        expected = ", ".join(alternatives[0].in_words() for alternatives in slots)
        raise MappingImpossible(
            sdo.node,
            f"{old.name} cannot be mapped as start_bit and bits ask for ({refused.problem}); expected "
            f"{expected}, the device has {old.in_words()}",
            "let vehicle.toml follow the device, or use another PDO",
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
