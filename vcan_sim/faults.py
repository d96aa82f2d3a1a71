"""Faults of devices: one class for each, all in `FAULTS`, the parser of their texts, and their schedule.

`reboot:node=2,at=30` is the fault `reboot` of node 2 at 30 s. Most faults change the device's `Disturbance`
while they last: the fields that they have in common with it, and those in `flags`.
"""

from __future__ import annotations

import heapq
import math
from dataclasses import dataclass, fields, replace
from functools import partial
from itertools import count
from typing import TYPE_CHECKING, Any, ClassVar, cast

from omnimate.vcan_sim.errors import FaultError
from omnimate.vcan_sim.key_values import BYTES, INTEGER, NUMBER, Kind, read_values
from omnimate.vcan_sim.nodes.transmitter import NONE, Babble, Disturbance

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from omnimate.vcan_sim.nodes.device import Device

_KINDS: dict[str, Kind] = {"float": NUMBER, "int": INTEGER, "int | None": INTEGER, "str | None": BYTES}
_DISTURBED = tuple(field.name for field in fields(Disturbance))
_BOUNDS = {"node": (1.0, 127.0), "at": (0.0, math.inf), "duration": (0.0, math.inf)}


@dataclass(frozen=True, slots=True, kw_only=True)
class DeviceFault:
    """Base class of the faults of devices."""

    name: ClassVar[str]
    bounds: ClassVar[dict[str, tuple[float, float]]] = {}
    flags: ClassVar[dict[str, Any]] = {}  # fields of `Disturbance` with a fixed value

    node: int  # node id of the device
    at: float = 0.0  # time at which the fault begins, on the devices' clock [s]
    duration: float = math.inf  # time for which the fault lasts [s]

    def __post_init__(self) -> None:
        """Refuse impossible values with a FaultError."""
        for key, (low, high) in {**_BOUNDS, **self.bounds}.items():
            value = getattr(self, key)
            if not low <= value <= high:
                raise FaultError(self.name, f"{key}={value} is impossible; expected {low:g} to {high:g}")

    def changes(self) -> dict[str, Any]:
        """Return the fields of `Disturbance` that the fault changes while it lasts."""
        return self.flags | {name: getattr(self, name) for name in _DISTURBED if hasattr(self, name)}

    def begin(self, device: Device, now: float) -> None:
        """Make the device faulty."""
        device.disturb(replace(device.transmitter.disturbance, **self.changes()), now)

    def end(self, device: Device, now: float) -> None:
        """End the fault."""
        healthy = {name: getattr(NONE, name) for name in self.changes()}
        device.disturb(replace(device.transmitter.disturbance, **healthy), now)


@dataclass(frozen=True, slots=True, kw_only=True)
class Silence(DeviceFault):
    """The device sends nothing, as with a broken transmit line; it still counts and receives."""

    name = "silence"
    flags: ClassVar[dict[str, Any]] = {"silent": True}


@dataclass(frozen=True, slots=True, kw_only=True)
class Reboot(DeviceFault):
    """The device loses power for `duration`, then boots: defaults, wheel counters at 0, pre-operational."""

    name = "reboot"
    flags: ClassVar[dict[str, Any]] = {"off": True}

    duration: float = 0.3

    def begin(self, device: Device, now: float) -> None:
        """Switch the device off."""
        device.switch_off(now)
        DeviceFault.begin(self, device, now)

    def end(self, device: Device, now: float) -> None:
        """Switch the device on again; it boots."""
        DeviceFault.end(self, device, now)
        device.reset(now)


@dataclass(frozen=True, slots=True, kw_only=True)
class WrongLength(DeviceFault):
    """The device's PDOs have another length than their mapping: cut, or filled up with zeros."""

    name = "length"
    bounds: ClassVar[dict[str, tuple[float, float]]] = {"length": (0, 8)}

    length: int = 3  # length of the PDOs [byte]


@dataclass(frozen=True, slots=True, kw_only=True)
class EmergencyMessage(DeviceFault):
    """The device reports an error by EMCY, and reports its end."""

    name = "emcy"
    bounds: ClassVar[dict[str, tuple[float, float]]] = {"code": (0x0001, 0xFFFF)}

    code: int = 0x5000  # error code of the EMCY message; by default 5000h (device hardware)

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
    """The device answers in time, but with its last data, as with a broken encoder disc."""

    name = "frozen"
    flags: ClassVar[dict[str, Any]] = {"frozen": True}


@dataclass(frozen=True, slots=True, kw_only=True)
class Babbling(DeviceFault):
    """The device floods the bus."""

    name = "babbling"
    bounds: ClassVar[dict[str, tuple[float, float]]] = {"frames": (1, 1000), "every": (1e-4, math.inf)}

    frames: int = 20  # number of frames in one burst
    # time between two bursts [s]; with the clock "sync" there is at most one burst per SYNC
    every: float = 0.01
    cob_id: int | None = None  # COB-ID of the frames; None for the device's own PDO
    data: str | None = None  # data of the frames, as hexadecimal digits; None for the last data of the PDO

    def changes(self) -> dict[str, Any]:
        """Set `babble`."""
        data = None if self.data is None else bytes.fromhex(self.data)
        return {"babble": Babble(self.frames, self.every, self.cob_id, data)}


@dataclass(frozen=True, slots=True, kw_only=True)
class ClockJitter(DeviceFault):
    """Some answers to SYNC are late; with the clock "sync" they follow the next SYNC."""

    name = "jitter"
    bounds: ClassVar[dict[str, tuple[float, float]]] = {"late_by": (0.0, 10.0), "late_every": (1, 1_000_000)}

    late_by: float = 0.01  # delay of a late answer [s]
    late_every: int = 2  # one of this number of answers is late


FAULTS: tuple[type[DeviceFault], ...] = (
    Silence,
    Reboot,
    WrongLength,
    EmergencyMessage,
    FrozenCounter,
    Babbling,
    ClockJitter,
)


def parse_fault(text: str) -> DeviceFault:
    """Return the fault that a text such as `emcy:node=3,at=12.5,duration=2,code=0x5000` describes.

    Raises FaultError for an unknown name or key, without a node, or for a value that is unreadable or out of
    bounds.
    """
    name, _, rest = text.partition(":")
    faults = {fault.name: fault for fault in FAULTS}
    if name not in faults:
        raise FaultError(text, f"unknown name {name!r}; expected one of {', '.join(faults)}")
    kinds = {field.name: _KINDS[str(field.type)] for field in fields(faults[name])}
    values = read_values(rest, kinds, partial(FaultError, text))
    if "node" not in values:
        raise FaultError(text, f"expected a node, as in `{name}:node=2`")
    return faults[name](**cast("dict[str, Any]", values))


class FaultSchedule:
    """Begins and ends faults as the clock passes their times; the next event is `due` [s]."""

    def __init__(self, devices: Mapping[int, Device], faults: Iterable[DeviceFault]) -> None:
        self._devices = devices
        self._order = count()  # order of the events of one time
        self._events: list[tuple[float, int, bool, DeviceFault]] = []
        self.due = math.inf
        for fault in faults:
            self.check(fault)
            self._add(fault.at, fault, begins=True)

    def check(self, fault: DeviceFault) -> None:
        """Raise FaultError if the fault's node is not on the bus."""
        if fault.node not in self._devices:
            nodes = ", ".join(str(node) for node in self._devices)
            raise FaultError(
                f"{fault.name}:node={fault.node}",
                f"no node {fault.node} on this bus; expected one of {nodes}",
            )

    def begin(self, fault: DeviceFault, now: float) -> None:
        """Begin a fault now [s], without regard to its `at`, and schedule its end."""
        fault.begin(self._devices[fault.node], now)
        if fault.duration < math.inf:
            self._add(now + fault.duration, fault, begins=False)

    def run(self, now: float) -> None:
        """Begin and end the faults whose times have passed [s]."""
        while self._events and self._events[0][0] <= now:
            _, _, begins, fault = heapq.heappop(self._events)
            if begins:
                self.begin(fault, now)
            else:
                fault.end(self._devices[fault.node], now)
        self.due = self._events[0][0] if self._events else math.inf

    def _add(self, time: float, fault: DeviceFault, *, begins: bool) -> None:
        heapq.heappush(self._events, (time, next(self._order), begins, fault))
        self.due = self._events[0][0]
