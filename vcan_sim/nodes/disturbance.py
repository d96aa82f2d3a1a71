"""What is wrong with a device at the moment: a plain record, which `Transmitter` follows."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Babble:
    """Frames with which a device floods the bus.

    Attributes:
        frames: Number of frames in one burst.
        every: Time between two bursts [s].
        cob_id: COB-ID of the frames; None for the device's own first TPDO.
        data: Data of the frames; None for what that TPDO sent last.
    """

    frames: int
    every: float
    cob_id: int | None
    data: bytes | None


@dataclass(frozen=True, slots=True)
class Disturbance:
    """The faults of a device.

    Attributes:
        off: Whether the device is without power: it neither receives nor sends.
        silent: Whether the device sends nothing.
        frozen: Whether the device's PDOs repeat what they sent last.
        length: Length that the device's PDOs are cut or filled up to [byte]; None for the right one.
        late_by: Time by which late PDOs are sent later [s].
        late_every: Number of PDOs of which one is late.
        babble: Frames with which the device floods the bus; None for none.
    """

    off: bool = False
    silent: bool = False
    frozen: bool = False
    length: int | None = None
    late_by: float = 0.0
    late_every: int = 1
    babble: Babble | None = None


NONE = Disturbance()
