"""What is wrong with a device at the moment; all null, nothing is."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Babble:
    """Frames that nobody asked for.

    Attributes:
        frames: in one burst.
        every: time between two bursts [s].
        cob_id: None for the device's own first TPDO.
        data: None for what that TPDO sent last.
    """

    frames: int
    every: float
    cob_id: int | None
    data: bytes | None


@dataclass(frozen=True, slots=True)
class Disturbance:
    """The faults of a device.

    Attributes:
        off: without power: it neither hears nor sends.
        silent: it sends nothing.
        frozen: its PDOs repeat what they sent last.
        length: that its PDOs are cut or filled up to [byte].
        late_by: how much later PDOs are sent [s].
        late_every: every how many PDOs are late.
        babble: what it floods the bus with.
    """

    off: bool = False
    silent: bool = False
    frozen: bool = False
    length: int | None = None
    late_by: float = 0.0
    late_every: int = 1
    babble: Babble | None = None


NONE = Disturbance()
