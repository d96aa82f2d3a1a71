"""The table of conformance: every check against the simulated devices and against canopen's `LocalNode`.

It is made by a run, and stands where a page has the line `[[conformance]]`.
"""

from __future__ import annotations

import logging
from collections import deque
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import can
import canopen

from omnimate.driver.conformance.probe import Probe
from omnimate.driver.conformance.run import CHECKS, Result, conform
from omnimate.vcan_sim.nodes.build import build_devices
from omnimate.vcan_sim.nodes.encoder import Latch
from omnimate.vcan_sim.nodes.router import Router
from omnimate.vcan_sim.reference import reference_vehicle

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

logging.getLogger("canopen").addHandler(logging.NullHandler())  # what LocalNode cannot handle it logs

PLACE = "[[conformance]]"
EDS = Path(__file__).parents[2] / "vcan_sim" / "eds" / "encoder_cia406.eds"
SYNC_ID, SYNC_PERIOD = 0x080, 0.015
WORDS = {"passed": "yes", "failed": "**no**: ", "absent": "-: "}


class Simulated:
    """The devices of the simulated reference robot, without its mechanics."""

    def __init__(self, send: Callable[[can.Message], None]) -> None:
        vehicle = reference_vehicle()
        self._latch = Latch([encoder.zero for encoder in vehicle.encoders], SYNC_PERIOD)
        self._devices = build_devices(vehicle, self._latch, lambda can_id, data: send(frame(can_id, data)))
        self._router = Router(self._devices)
        for device in self._devices:
            device.boot(0.0)

    @property
    def due(self) -> float:
        """Time of the next timer [s]."""
        return min(device.due for device in self._devices)

    def receive(self, message: can.Message, now: float) -> None:
        """Take a frame at a time [s]."""
        self._router.receive(message, now)

    def run(self, now: float) -> None:
        """Do what is due at a time [s]."""
        for device in self._devices:
            if device.due <= now:
                device.run_timers(now)


class Local(canopen.Network):
    """canopen's `LocalNode` with the EDS of the simulated encoder; its heartbeat follows the bus's time."""

    def __init__(self, send: Callable[[can.Message], None], node: int = 1) -> None:
        super().__init__()
        self._send = send
        self._period, self._beat = 0.0, b""
        self._identifier, self.due = 0, float("inf")
        self._node = canopen.LocalNode(node, canopen.import_od(str(EDS), node))
        self._node.associate_network(self)
        self._now = 0.0
        self._listener = canopen.network.MessageListener(self)  # what it cannot handle it logs, and goes on

    def send_message(self, can_id: int, data: bytes, remote: bool = False) -> None:  # noqa: ARG002  # canopen
        """Send a frame."""
        self._send(frame(can_id, data))

    def send_periodic(self, can_id: int, data: bytes, period: float, remote: bool = False) -> Any:  # noqa: ANN401, ARG002
        """Send a frame again and again."""
        self._identifier, self._beat, self._period = can_id, bytes(data), period
        self.due = self._now + period
        return SimpleNamespace(stop=self._stop, update=self._update)

    def _stop(self) -> None:
        self.due = float("inf")

    def _update(self, data: bytes) -> None:
        self._beat = bytes(data)

    def receive(self, message: can.Message, now: float) -> None:
        """Take a frame at a time [s]."""
        self._now = now
        self._listener.on_message_received(message)

    def run(self, now: float) -> None:
        """Do what is due at a time [s]."""
        self._now = now
        if self.due <= now:
            self.due += self._period
            self._send(frame(self._identifier, self._beat))


class BenchBus(can.BusABC):
    """A bus whose time goes on while somebody waits for a frame.

    Attributes:
        time: Time on the bus [s].
    """

    def __init__(self, kind: Callable[[Callable[[can.Message], None]], Simulated | Local]) -> None:
        self.time = 0.0
        self._waiting: deque[can.Message] = deque()
        self.channel_info = "bench"
        super().__init__(channel="bench")
        self._is_shutdown = True  # there is nothing to shut down
        self._devices = kind(self._waiting.append)

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Give a frame to the devices."""
        del timeout
        self._devices.receive(msg, self.time)

    def recv(self, timeout: float | None = None) -> can.Message | None:
        """Return the next frame, or None when the time is over."""
        end = self.time + (timeout or 0.0)
        while not self._waiting and self._devices.due <= end:
            self.time = max(self.time, self._devices.due)
            self._devices.run(self.time)
        if not self._waiting:
            self.time = end
        return self._waiting.popleft() if self._waiting else None


def frame(can_id: int, data: bytes) -> can.Message:
    """Return a frame with an 11-bit identifier."""
    return can.Message(arbitration_id=can_id, data=bytes(data), is_extended_id=False)


def results_of(
    kind: Callable[[Callable[[can.Message], None]], Simulated | Local], node: int
) -> tuple[Result, ...]:
    """Return the results of all checks against a node."""
    bus = BenchBus(kind)
    return tuple(conform(Probe(bus, node, timeout=0.1, clock=lambda: bus.time), "stores"))


@cache
def all_results() -> Mapping[str, tuple[Result, ...]]:
    """Return the results of all checks against each device of the table."""
    vehicle = reference_vehicle()
    return {
        "encoder": results_of(Simulated, vehicle.encoders[0].node),
        "drive": results_of(Simulated, vehicle.drives[0].node),
        "canopen LocalNode": results_of(Local, 1),
    }


def on_page_markdown(markdown: str, **_: object) -> str:
    """Put the table into the page that asks for it."""
    return markdown.replace(PLACE, table()) if PLACE in markdown else markdown


def table() -> str:
    """Return the table as Markdown."""
    columns = all_results()
    rows = [
        "| standard | subject | demand | " + " | ".join(columns) + " |",
        "| --- " * (3 + len(columns)) + "|",
    ]
    for number, check in enumerate(CHECKS):
        cells = [_cell(results[number]) for results in columns.values()]
        rows.append("| " + " | ".join((check.standard, check.subject, check.demand, *cells)) + " |")
    return "\n".join(rows)


def _cell(result: Result) -> str:
    return WORDS[result.outcome] + result.reason.replace("|", "/")
