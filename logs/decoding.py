"""One frame in words: a vehicle's channels with their physical values, CANopen services, or neither."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from omnimate.logs.canopen_words import describe_frame
from omnimate.logs.frames import ERROR, EXTENDED, REMOTE, Frame
from omnimate.logs.pdo_units import drive_conversion, encoder_conversion

if TYPE_CHECKING:
    from omnimate.logs.pdo_units import Conversion
    from omnimate.vehicle.parameters import VehicleParameters


class _Field(NamedTuple):
    """A number in a PDO."""

    name: str
    start_bit: int
    bits: int
    signed: bool
    conversion: Conversion

    def in_words(self, data: bytes) -> str:
        """Return the field's name and value in the data of a PDO."""
        if 8 * len(data) < self.start_bit + self.bits:
            return f"{self.name}: wrong length, {len(data)} bytes"
        raw = int.from_bytes(data, "little") >> self.start_bit & ((1 << self.bits) - 1)
        if self.signed and raw >> (self.bits - 1):
            raw -= 1 << self.bits
        return f"{self.name} = {self.conversion(raw):.6g} {self.conversion.unit} ({raw} counts)"


class FrameDecoder:
    """Says what frames mean; without a vehicle, what the predefined connection set of CANopen says."""

    def __init__(self, vehicle: VehicleParameters | None) -> None:
        """Prepare the names of a vehicle's PDOs and nodes."""
        self._vehicle = vehicle
        self._fields: dict[int, list[_Field]] = {}
        self._nodes: dict[int, list[str]] = {}
        if vehicle is None:
            return
        for encoder in vehicle.encoders:
            conversion = encoder_conversion(encoder, vehicle)
            self._add(
                encoder.cob_id,
                encoder.node,
                _Field(encoder.channel, encoder.start_bit, encoder.bits, encoder.signed, conversion),
            )
        for drive in vehicle.drives:
            field = _Field(f"target {drive.wheel}", 0, 32, signed=True, conversion=drive_conversion(drive))
            self._add(drive.cob_id, drive.node, field)

    def _add(self, cob_id: int, node: int, field: _Field) -> None:
        self._fields.setdefault(cob_id, []).append(field)
        self._nodes.setdefault(node, []).append(field.name)

    def __call__(self, frame: Frame) -> str:
        """Return what a frame means."""
        if frame.flags & ERROR:
            return "error frame of the adapter"
        if frame.flags & EXTENDED:
            return "not CANopen: 29-bit identifier"
        if frame.can_id in self._fields and not frame.flags & REMOTE:
            return self._values(frame)
        words = describe_frame(frame.can_id, frame.data, remote=bool(frame.flags & REMOTE))
        if words is None:
            return "not CANopen: no such COB-ID or length in the predefined connection set"
        return words + self._whose(frame.can_id)

    def name(self, can_id: int, flags: int, data: bytes) -> str:
        """Return what an identifier carries, without the values."""
        if not flags & (EXTENDED | ERROR | REMOTE) and can_id in self._fields:
            return ", ".join(field.name for field in self._fields[can_id])
        if can_id == 0:
            return "NMT"
        return self(Frame(0.0, can_id, data, flags)).partition(":")[0].partition(",")[0]

    def _values(self, frame: Frame) -> str:
        return ", ".join(field.in_words(frame.data) for field in self._fields[frame.can_id])

    def _whose(self, can_id: int) -> str:
        """Return whose frame it is, where a vehicle is known."""
        node = can_id & 0x7F
        if self._vehicle is None or node == 0 or can_id > 0x77F:
            return ""
        if node not in self._nodes or 0x180 <= can_id < 0x580:  # its own PDOs are decoded elsewhere
            return " (not of this vehicle)"
        return f" ({', '.join(self._nodes[node])})"
