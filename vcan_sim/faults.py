"""Faults that devices show: one small class each, all in `FAULTS`, written as `reboot:node=2,at=30`."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any, ClassVar

from vcan_sim.errors import FaultError
from vcan_sim.nodes.disturbance import Babble

if TYPE_CHECKING:
    from vcan_sim.nodes.device import Device


_BOUNDS = {"node": (1.0, 127.0), "at": (0.0, math.inf), "duration": (0.0, math.inf)}


@dataclass(frozen=True, slots=True, kw_only=True)
class Fault:
    """What all faults have.

    Attributes:
        node: the device's node id.
        at: when it begins, on the devices' clock [s].
        duration: how long it lasts [s].
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
        """Make it sound again."""
        raise NotImplementedError


def _disturb(device: Device, now: float, **changes: Any) -> None:  # noqa: ANN401 - fields of several types
    device.disturb(replace(device.transmitter.disturbance, **changes), now)


@dataclass(frozen=True, slots=True, kw_only=True)
class Silence(Fault):
    """The device sends nothing, as with a broken transmit line; it counts and hears on."""

    name: ClassVar[str] = "silence"

    def begin(self, device: Device, now: float) -> None:
        """Cut the line."""
        _disturb(device, now, silent=True)

    def end(self, device: Device, now: float) -> None:
        """Mend the line."""
        _disturb(device, now, silent=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class Reboot(Fault):
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
class WrongLength(Fault):
    """The device's PDOs have another length than their mapping.

    Attributes:
        length: [byte].
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
class EmergencyMessage(Fault):
    """The device reports an error by EMCY, and takes it back at the end.

    Attributes:
        code: of the error, 5000h (device hardware) unless another is given.
    """

    name: ClassVar[str] = "emcy"
    bounds: ClassVar[dict[str, tuple[float, float]]] = {"code": (0x0001, 0xFFFF)}

    code: int = 0x5000

    def begin(self, device: Device, now: float) -> None:
        """Report."""
        device.now = now
        device.emergency.set(self.code)

    def end(self, device: Device, now: float) -> None:
        """Take it back."""
        device.now = now
        device.emergency.clear(self.code)


@dataclass(frozen=True, slots=True, kw_only=True)
class FrozenCounter(Fault):
    """The device answers in time with what it sent last, as with a broken disc."""

    name: ClassVar[str] = "frozen"

    def begin(self, device: Device, now: float) -> None:
        """Hold the value."""
        _disturb(device, now, frozen=True)

    def end(self, device: Device, now: float) -> None:
        """Let it go."""
        _disturb(device, now, frozen=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class Babbling(Fault):
    """The device floods the bus.

    Attributes:
        frames: in one burst.
        every: time between bursts [s]; on a clock of SYNCs, one burst per SYNC at most.
        cob_id: of the frames; the device's own PDO unless given.
        data: of the frames, as hexadecimal digits; what was sent last unless given.
    """

    name: ClassVar[str] = "babbling"
    bounds: ClassVar[dict[str, tuple[float, float]]] = {"frames": (1, 1000), "every": (1e-4, math.inf)}

    frames: int = 20
    every: float = 0.01
    cob_id: int | None = None
    data: str | None = None

    def begin(self, device: Device, now: float) -> None:
        """Start to babble."""
        data = None if self.data is None else bytes.fromhex(self.data)
        _disturb(device, now, babble=Babble(self.frames, self.every, self.cob_id, data))

    def end(self, device: Device, now: float) -> None:
        """Fall silent."""
        _disturb(device, now, babble=None)


@dataclass(frozen=True, slots=True, kw_only=True)
class ClockJitter(Fault):
    """Some answers to SYNC come late; on a clock of SYNCs, after the next one.

    Attributes:
        late_by: how much later [s].
        late_every: every how many answers are late.
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


FAULTS: tuple[type[Fault], ...] = (
    Silence,
    Reboot,
    WrongLength,
    EmergencyMessage,
    FrozenCounter,
    Babbling,
    ClockJitter,
)


def parse_fault(text: str) -> Fault:
    """Return the fault that a text such as `emcy:node=3,at=12.5,duration=2,code=0x5000` describes.

    Raises:
        FaultError: unknown name or key, missing node, or a value that is none.
    """
    name, _, rest = text.partition(":")
    kinds = {kind.name: kind for kind in FAULTS}
    if name not in kinds:
        raise FaultError(text, f"unknown name {name!r}; expected one of {', '.join(kinds)}")
    types = {field.name: str(field.type) for field in fields(kinds[name])}
    values: dict[str, Any] = {}
    for pair in filter(None, rest.split(",")):
        key, equals, value = pair.partition("=")
        if key not in types or not equals:
            raise FaultError(text, f"{pair!r} is not understood; expected key=value with {', '.join(types)}")
        values[key] = _value(text, key, types[key], value)
    if "node" not in values:
        raise FaultError(text, f"whose? expected a node, as in `{name}:node=2`")
    return kinds[name](**values)


def _value(text: str, key: str, kind: str, value: str) -> float | str:
    """Return a value as its field's type has it."""
    try:
        if "str" in kind:
            return bytes.fromhex(value)[:8].hex()
        return float(value) if kind == "float" else int(value, 0)
    except ValueError:
        expected = {"float": "a number"}.get(kind, "hexadecimal digits" if "str" in kind else "an integer")
        raise FaultError(text, f"{key}={value}: expected {expected}") from None
