"""Where an encoder's counts stand in its PDO."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from omnimate.vehicle.parameters import Encoder


@dataclass(frozen=True, slots=True)
class PdoField:
    """The bits of one encoder in its PDO.

    Attributes:
        column: Column of the channel in `vehicle.channels`.
        shift: Number of the first bit.
        mask: As many one bits as the field is wide.
        half: Weight of the sign bit; 0 where the field is unsigned.
    """

    column: int
    shift: int
    mask: int
    half: int

    def decode(self, word: int) -> int:
        """Return the raw counts in a PDO that is given as one little-endian number."""
        raw = (word >> self.shift) & self.mask
        return (raw ^ self.half) - self.half


def field_of(encoder: Encoder, column: int) -> PdoField:
    """Return the field of an encoder whose channel has this column in `vehicle.channels`."""
    half = 1 << (encoder.bits - 1) if encoder.signed else 0
    return PdoField(column, encoder.start_bit, (1 << encoder.bits) - 1, half)
