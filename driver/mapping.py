"""Which objects a PDO must carry, so that the fields of `vehicle.toml` hold."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from driver.errors import MappingImpossible

if TYPE_CHECKING:
    from collections.abc import Sequence

    from vehicle.parameters import Channel, Encoder

AXIS = 0x800  # distance of the objects of two axes of one CiA 402 device


@dataclass(frozen=True, slots=True)
class Entry:
    """An object in a PDO.

    Attributes:
        index: of the object.
        subindex: of it.
        bits: width.
    """

    index: int
    subindex: int
    bits: int

    @property
    def value(self) -> int:
        """As it stands in 1A00h:n."""
        return self.index << 16 | self.subindex << 8 | self.bits

    @classmethod
    def of(cls, value: int) -> Entry:
        """Return the entry that a value of 1A00h:n means."""
        return cls(value >> 16 & 0xFFFF, value >> 8 & 0xFF, value & 0xFF)

    def in_words(self) -> str:
        """Return it as `6004h:00 32 bits`."""
        return f"{self.index:04X}h:{self.subindex:02X} {self.bits} bits"


# What may fill a gap: something that the device has anyway, or else CiA 301's dummy objects.
_FILLERS: dict[str, dict[int, tuple[Entry, ...]]] = {
    "cia406": {
        16: (Entry(0x6500, 0, 16), Entry(0x0006, 0, 16)),
        8: (Entry(0x1001, 0, 8), Entry(0x0005, 0, 8)),
    },
    "cia402": {
        16: (Entry(0x6041, 0, 16), Entry(0x0006, 0, 16)),
        8: (Entry(0x1001, 0, 8), Entry(0x0005, 0, 8)),
    },
}


def position_objects(encoders: Sequence[Encoder]) -> dict[Channel, Entry]:
    """Return the position object of each channel of one node, in the order of COB-ID and start bit.

    6004h of a CiA 406 encoder, 6020h:1..n of one with several sensors, 6064h of a CiA 402 drive and 800h
    further for each further axis.
    """
    ordered = sorted(encoders, key=lambda one: (one.cob_id, one.start_bit))
    objects: dict[Channel, Entry] = {}
    for number, one in enumerate(ordered):
        if one.profile == "cia402":
            objects[one.channel] = Entry(0x6064 + AXIS * number, 0, one.bits)
        elif len(ordered) == 1:
            objects[one.channel] = Entry(0x6004, 0, one.bits)
        else:
            objects[one.channel] = Entry(0x6020, number + 1, one.bits)
    return objects


def holds(entries: Sequence[Entry], encoders: Sequence[Encoder], objects: dict[Channel, Entry]) -> bool:
    """Say whether a mapping has each encoder's object at its start bit, whatever else it carries."""
    starts, bit = {}, 0
    for entry in entries:
        starts[bit] = entry
        bit += entry.bits
    return all(starts.get(one.start_bit) == objects[one.channel] for one in encoders)


def plan(encoders: Sequence[Encoder], objects: dict[Channel, Entry]) -> tuple[tuple[Entry, ...], ...]:
    """Return the entries of one PDO in order; each is a tuple of alternatives, the best first.

    Raises:
        MappingImpossible: a gap between two fields is no whole number of bytes.
    """
    slots: list[tuple[Entry, ...]] = []
    bit = 0
    for one in sorted(encoders, key=lambda encoder: encoder.start_bit):
        slots += _fill(one, one.start_bit - bit)
        slots.append((objects[one.channel],))
        bit = one.start_bit + one.bits
    return tuple(slots)


def _fill(encoder: Encoder, gap: int) -> list[tuple[Entry, ...]]:
    if gap % 8:
        raise MappingImpossible(
            encoder.node, f"start_bit of {encoder.channel} leaves {gap} bits free; expected a multiple of 8"
        )
    fillers = _FILLERS[encoder.profile]
    return [*[fillers[16]] * (gap // 16), *[fillers[8]] * (gap % 16 // 8)]


def length(entries: Sequence[Entry]) -> int:
    """Return the bytes of a PDO with these entries."""
    return (sum(entry.bits for entry in entries) + 7) // 8
