"""The objects that a PDO must carry, so that it has the fields of `vehicle.toml`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from omnimate.driver.errors import MappingImpossible

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from omnimate.vehicle.parameters import Channel, Encoder

AXIS = 0x800  # between the objects of two axes of one CiA 402 device: two logical devices of CiA 301


@dataclass(frozen=True, slots=True)
class Entry:
    """An object in a PDO."""

    index: int
    subindex: int
    bits: int  # width of the object in the PDO [bit]

    @property
    def value(self) -> int:
        """The entry as a value of the mapping parameters, such as 1A00h:01 (CiA 301, 7.5.2.38)."""
        return self.index << 16 | self.subindex << 8 | self.bits

    @classmethod
    def of(cls, value: int) -> Entry:
        """Return the entry that a value of the mapping parameters means."""
        return cls(value >> 16 & 0xFFFF, value >> 8 & 0xFF, value & 0xFF)

    def in_words(self) -> str:
        """Return the entry as text such as `6004h:00 32 bits`."""
        return f"{self.index:04X}h:{self.subindex:02X} {self.bits} bits"


# What may fill a gap: something that the device has in any case, or else the dummy objects of CiA 301.
_FILLERS: dict[str, dict[int, tuple[Entry, ...]]] = {
    profile: {16: (Entry(status, 0, 16), Entry(0x0006, 0, 16)), 8: (Entry(0x1001, 0, 8), Entry(0x0005, 0, 8))}
    for profile, status in (("cia406", 0x6500), ("cia402", 0x6041))
}


def position_objects(encoders: Sequence[Encoder]) -> dict[Channel, Entry]:
    """Return the position object of each channel of one node, in the order of COB-ID and start bit.

    It is what `vehicle.toml` names; else 6004h of a CiA 406 encoder, 6020h:1..n of one with several sensors,
    6064h of a CiA 402 drive and 800h further for each further axis.
    """
    ordered = sorted(encoders, key=lambda encoder: (encoder.cob_id, encoder.start_bit))
    objects: dict[Channel, Entry] = {}
    for number, encoder in enumerate(ordered):
        if encoder.position_object is not None:
            objects[encoder.channel] = Entry(*encoder.position_object, encoder.bits)
        elif encoder.profile == "cia402":
            objects[encoder.channel] = Entry(0x6064 + AXIS * number, 0, encoder.bits)
        elif len(ordered) == 1:
            objects[encoder.channel] = Entry(0x6004, 0, encoder.bits)
        else:
            objects[encoder.channel] = Entry(0x6020, number + 1, encoder.bits)
    return objects


def placed(entries: Sequence[Entry]) -> Iterator[tuple[int, Entry]]:
    """Yield each entry of a PDO with its first bit."""
    bit = 0
    for entry in entries:
        yield bit, entry
        bit += entry.bits


def holds(entries: Sequence[Entry], encoders: Sequence[Encoder], objects: dict[Channel, Entry]) -> bool:
    """Return whether a mapping has each encoder's object at its start bit, whatever else it carries."""
    starts = dict(placed(entries))
    return all(starts.get(encoder.start_bit) == objects[encoder.channel] for encoder in encoders)


def plan(encoders: Sequence[Encoder], objects: dict[Channel, Entry]) -> tuple[tuple[Entry, ...], ...]:
    """Return the entries of a PDO with the fields of encoders; each is a tuple, the best first.

    Raises MappingImpossible where a gap between two fields is no whole number of bytes.
    """
    slots: list[tuple[Entry, ...]] = []
    bit = 0
    for encoder in sorted(encoders, key=lambda encoder: encoder.start_bit):
        slots += _fill(encoder, encoder.start_bit - bit)
        slots.append((objects[encoder.channel],))
        bit = encoder.start_bit + encoder.bits
    return tuple(slots)


def _fill(encoder: Encoder, gap: int) -> list[tuple[Entry, ...]]:
    if gap % 8:
        raise MappingImpossible(
            encoder.node,
            f"start_bit {encoder.start_bit} of {encoder.channel} leaves a gap of {gap} bits in COB-ID "
            f"{encoder.cob_id:03X}h; expected a multiple of 8",
            "correct start_bit or bits in vehicle.toml",
        )
    fillers = _FILLERS[encoder.profile]
    return [*[fillers[16]] * (gap // 16), *[fillers[8]] * (gap % 16 // 8)]


def length(entries: Sequence[Entry]) -> int:
    """Return the length of a PDO with these entries [bytes]."""
    return (sum(entry.bits for entry in entries) + 7) // 8
