"""Units of raw counts in PDOs, and what frames mean: physical values of a vehicle, or CANopen services."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from omnimate.files.logs.canopen_words import describe_frame
from omnimate.files.logs.frames import ERROR, EXTENDED, FD, REMOTE, Frame
from omnimate.files.logs.signals import EXTENDED_KEY, Signal

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from omnimate.vehicle.parameters import Drive, Encoder, VehicleParameters


class Conversion(NamedTuple):
    """physical = offset + factor * raw.

    The factor is in units per count; the unit is `rad`, `m` or `rad/s`.
    """

    factor: float
    offset: float
    unit: str

    def __call__(self, raw: float) -> float:
        """Return the physical value of raw counts."""
        return self.offset + self.factor * raw


def encoder_conversion(encoder: Encoder, vehicle: VehicleParameters) -> Conversion:
    """Return the conversion of an encoder's counts, before they are unwrapped."""
    if encoder.channel == "link":
        length = vehicle.linkage.length if vehicle.linkage else 0.0
        return Conversion(encoder.scale, length - encoder.zero * encoder.scale, "m")
    zero = encoder.zero if encoder.channel in {"joint_a", "joint_b"} else 0
    return Conversion(encoder.scale, 0.0 - zero * encoder.scale, "rad")


def drive_conversion(drive: Drive) -> Conversion:
    """Return the conversion of a drive's target velocity (60FFh) to wheel speed, forward positive."""
    return Conversion(drive.sign * 2.0 * math.pi / drive.counts_per_turn, 0.0, "rad/s")


def vehicle_signals(vehicle: VehicleParameters) -> dict[int, tuple[Signal, ...]]:
    """Return the channels and drive targets in a vehicle's PDOs, by COB-ID."""
    signals: dict[int, tuple[Signal, ...]] = {}
    for encoder in vehicle.encoders:
        place = encoder.start_bit, encoder.bits, encoder.signed
        signal = Signal(encoder.channel, *place, *encoder_conversion(encoder, vehicle), counts="counts")
        signals[encoder.cob_id] = (*signals.get(encoder.cob_id, ()), signal)
    for drive in vehicle.drives:
        place = drive.start_bit, 32, True
        signal = Signal(f"target {drive.wheel}", *place, *drive_conversion(drive), counts="counts")
        signals[drive.cob_id] = (*signals.get(drive.cob_id, ()), signal)
    return signals


class FrameDecoder:
    """Describes frames by known signals, or by the predefined connection set of CANopen.

    Attributes:
        signals: Signals by identifier, to which `EXTENDED_KEY` is added for 29 bits.
    """

    def __init__(
        self,
        vehicle: VehicleParameters | None = None,
        signals: Mapping[int, Sequence[Signal]] | None = None,
    ) -> None:
        """Set the known signals of the bus; those of a vehicle have priority.

        The others are those of a DBC file, an object dictionary or a mapping, by identifier.
        """
        self._vehicle = vehicle
        vehicle_known = vehicle_signals(vehicle) if vehicle is not None else {}
        self.signals: dict[int, Sequence[Signal]] = {**(signals or {}), **vehicle_known}
        self._nodes: dict[int, list[str]] = {}
        if vehicle is not None:
            owners = [(encoder.node, str(encoder.channel)) for encoder in vehicle.encoders]
            owners += [(drive.node, f"target {drive.wheel}") for drive in vehicle.drives]
            for node, name in owners:
                self._nodes.setdefault(node, []).append(name)

    def __call__(self, frame: Frame) -> str:
        """Return the description of a frame."""
        if frame.flags & ERROR:
            return "error frame of the adapter"
        carried = () if frame.flags & REMOTE else self._carried(frame.can_id, frame.flags)
        if carried:
            return ", ".join(s.in_words(frame.data) for s in carried if s.is_in(frame.data))
        if frame.flags & FD:
            return "not CANopen: a CAN FD frame"
        if frame.flags & EXTENDED:
            return "not CANopen: 29-bit identifier"
        words = describe_frame(frame.can_id, frame.data, remote=bool(frame.flags & REMOTE))
        if words is None:
            return "not CANopen: no such COB-ID or length in the predefined connection set"
        return words + self._whose(frame.can_id)

    def name(self, can_id: int, flags: int, data: bytes) -> str:
        """Return the names of an identifier's signals or its service, without values."""
        carried = () if flags & (ERROR | REMOTE) else self._carried(can_id, flags)
        if carried:
            return ", ".join(signal.name for signal in carried)
        if can_id == 0:
            return "NMT"
        return self(Frame(0.0, can_id, data, flags)).partition(":")[0].partition(",")[0]

    def _carried(self, can_id: int, flags: int) -> Sequence[Signal]:
        return self.signals.get(can_id | (EXTENDED_KEY if flags & EXTENDED else 0), ())

    def _whose(self, can_id: int) -> str:
        """Return the vehicle's devices of a frame's node; empty without a vehicle."""
        node = can_id & 0x7F
        if self._vehicle is None or node == 0 or can_id > 0x77F:
            return ""
        if node not in self._nodes or 0x180 <= can_id < 0x580:  # its own PDOs are decoded elsewhere
            return " (not of this vehicle)"
        return f" ({', '.join(self._nodes[node])})"
