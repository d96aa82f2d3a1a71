"""Faults of devices: one small class for each, all of them in `FAULTS`."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar

from omnimate.vcan_sim.errors import FaultError
from omnimate.vcan_sim.nodes.disturbance import Babble

if TYPE_CHECKING:
    from omnimate.vcan_sim.nodes.device import Device


_BOUNDS = {"node": (1.0, 127.0), "at": (0.0, math.inf), "duration": (0.0, math.inf)}


@dataclass(frozen=True, slots=True, kw_only=True)
class DeviceFault:
    """What all faults of devices have in common.

    Attributes:
        node: Node id of the device.
        at: Time at which the fault begins, on the devices' clock [s].
        duration: Time for which the fault lasts [s].
    """

    name: ClassVar[str]
    bounds: ClassVar[dict[str, tuple[float, float]]] = {}

    node: int
    at: float = 0.0
    duration: float = math.inf

    def __post_init__(self) -> None:
        """Refuse impossible values with a FaultError."""
        for key, (low, high) in {**_BOUNDS, **self.bounds}.items():
            value = getattr(self, key)
            if not low <= value <= high:
                raise FaultError(self.name, f"{key}={value} is impossible; expected {low:g} to {high:g}")

    def begin(self, device: Device, now: float) -> None:
        """Make the device faulty."""
        raise NotImplementedError

    def end(self, device: Device, now: float) -> None:
        """End the fault."""
        raise NotImplementedError


def _disturb(device: Device, now: float, **changes: Any) -> None:  # noqa: ANN401 - fields of several types
    device.disturb(replace(device.transmitter.disturbance, **changes), now)


@dataclass(frozen=True, slots=True, kw_only=True)
class Silence(DeviceFault):
    """The device sends nothing, as with a broken transmit line; it still counts and receives."""

    name: ClassVar[str] = "silence"

    def begin(self, device: Device, now: float) -> None:
        """Cut the line."""
        _disturb(device, now, silent=True)

    def end(self, device: Device, now: float) -> None:
        """Connect the line again."""
        _disturb(device, now, silent=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class Reboot(DeviceFault):
    """The device loses power for `duration`, then boots: defaults, wheel counters at 0, pre-operational."""

    name: ClassVar[str] = "reboot"

    duration: float = 0.3

    def begin(self, device: Device, now: float) -> None:
        """Take the power away."""
        device.switch_off(now)
        _disturb(device, now, off=True)

    def end(self, device: Device, now: float) -> None:
        """Give the power back."""
        _disturb(device, now, off=False)
        device.reset(now)


@dataclass(frozen=True, slots=True, kw_only=True)
class WrongLength(DeviceFault):
    """The device's PDOs have another length than their mapping.

    Attributes:
        length: Length of the PDOs [byte].
    """

    name: ClassVar[str] = "length"
    bounds: ClassVar[dict[str, tuple[float, float]]] = {"length": (0, 8)}

    length: int = 3

    def begin(self, device: Device, now: float) -> None:
        """Cut the PDOs, or fill them up with zeros."""
        _disturb(device, now, length=self.length)

    def end(self, device: Device, now: float) -> None:
        """Send them whole again."""
        _disturb(device, now, length=None)


@dataclass(frozen=True, slots=True, kw_only=True)
class EmergencyMessage(DeviceFault):
    """The device reports an error by EMCY, and reports its end.

    Attributes:
        code: Error code of the EMCY message; 5000h (device hardware) unless another is given.
    """

    name: ClassVar[str] = "emcy"
    bounds: ClassVar[dict[str, tuple[float, float]]] = {"code": (0x0001, 0xFFFF)}

    code: int = 0x5000

    def begin(self, device: Device, now: float) -> None:
        """Report the error."""
        device.now = now
        device.emergency.set(self.code)

    def end(self, device: Device, now: float) -> None:
        """Report the end of the error."""
        device.now = now
        device.emergency.clear(self.code)


@dataclass(frozen=True, slots=True, kw_only=True)
class FrozenCounter(DeviceFault):
    """The device answers in time with what it sent last, as with a broken disc."""

    name: ClassVar[str] = "frozen"

    def begin(self, device: Device, now: float) -> None:
        """Repeat the last values."""
        _disturb(device, now, frozen=True)

    def end(self, device: Device, now: float) -> None:
        """Send the present values again."""
        _disturb(device, now, frozen=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class Babbling(DeviceFault):
    """The device floods the bus.

    Attributes:
        frames: Number of frames in one burst.
        every: Time between two bursts [s]; on a clock of SYNCs there is at most one burst per SYNC.
        cob_id: COB-ID of the frames; None for the device's own PDO.
        data: Data of the frames, as hexadecimal digits; None for what the PDO sent last.
    """

    name: ClassVar[str] = "babbling"
    bounds: ClassVar[dict[str, tuple[float, float]]] = {"frames": (1, 1000), "every": (1e-4, math.inf)}

    frames: int = 20
    every: float = 0.01
    cob_id: int | None = None
    data: str | None = None

    def begin(self, device: Device, now: float) -> None:
        """Begin to flood the bus."""
        data = None if self.data is None else bytes.fromhex(self.data)
        _disturb(device, now, babble=Babble(self.frames, self.every, self.cob_id, data))

    def end(self, device: Device, now: float) -> None:
        """Stop flooding the bus."""
        _disturb(device, now, babble=None)


@dataclass(frozen=True, slots=True, kw_only=True)
class ClockJitter(DeviceFault):
    """Some answers to SYNC come late; on a clock of SYNCs, after the next one.

    Attributes:
        late_by: Time by which a late answer is late [s].
        late_every: Number of answers of which one is late.
    """

    name: ClassVar[str] = "jitter"
    bounds: ClassVar[dict[str, tuple[float, float]]] = {"late_by": (0.0, 10.0), "late_every": (1, 1_000_000)}

    late_by: float = 0.01
    late_every: int = 2

    def begin(self, device: Device, now: float) -> None:
        """Hold answers back."""
        _disturb(device, now, late_by=self.late_by, late_every=self.late_every)

    def end(self, device: Device, now: float) -> None:
        """Answer in time again."""
        _disturb(device, now, late_by=0.0, late_every=1)


FAULTS: tuple[type[DeviceFault], ...] = (
    Silence,
    Reboot,
    WrongLength,
    EmergencyMessage,
    FrozenCounter,
    Babbling,
    ClockJitter,
)
