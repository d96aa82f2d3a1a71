"""Produces SYNC, reads the encoders, supervises the nodes, and recovers what can be recovered."""

from __future__ import annotations

import contextlib
import time
from typing import TYPE_CHECKING, Self

import can

from driver import load
from driver.bus import open_bus
from driver.clock import Clock, WallClock
from driver.configure import (
    HEARTBEAT_MS,
    ConfigurationReport,
    NodeConfiguration,
    configure_node,
    with_ranges,
)
from driver.drives import Drives
from driver.errors import BusError, BusLost
from driver.frozen import FrozenWatch
from driver.link import NMT_START, Link
from driver.monitor import Monitor
from driver.recovery import Recovery
from driver.report import DriverReport, make_report

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from canopen.objectdictionary import ObjectDictionary

    from driver.link import FrameSink
    from driver.sdo import Sdo
    from vehicle.parameters import VehicleParameters
    from vehicle.sample import Sample

SETTLE = 0.01  # [s] of host time for PDOs that are only hoped for
MAX_DRAIN = 20_000  # frames read before a SYNC; more than two seconds of a full 1 Mbit/s bus
FIRST_DELAY, LONGEST_DELAY = 0.1, 5.0  # [s] before a lost bus is opened again
WATCHED_OBJECTS = (0x6509, 0x650B)  # that tell of a preset or a swapped encoder


class Driver:
    """The master of one vehicle's bus; use it as a context manager, in one thread.

    Attributes:
        vehicle: with the ranges that were found in `configure`.
        drives: of the wheels.
    """

    def __init__(
        self,
        vehicle: VehicleParameters,
        bus: can.BusABC | str,
        *,
        clock: Clock | None = None,
        recorder: FrameSink | None = None,
        dictionaries: Mapping[int, ObjectDictionary] | None = None,
        patience: float = 30.0,
        watchdog: float = 0.2,
    ) -> None:
        """Open the bus where it is given as a URL; nothing is sent yet.

        Args:
            vehicle: as its owner believes it to be.
            bus: URL, which is opened again when the bus is lost, or a bus that the caller owns.
            clock: pace of SYNC; wall clock by default.
            recorder: gets every frame sent and received.
            dictionaries: object dictionaries by node, where there are EDS files; none is needed.
            patience: how long a lost bus is tried to be opened again [s].
            watchdog: after which without a command the wheels are stopped [s].

        Raises:
            BusError: the URL's bus cannot be opened.
        """
        self.vehicle = vehicle
        self._url = bus if isinstance(bus, str) else None
        self._clock: Clock = clock or WallClock(vehicle.bus.sync_period)
        self._link = Link(open_bus(bus) if isinstance(bus, str) else bus, self._clock, recorder)
        self._monitor = Monitor(vehicle, self._clock)
        self._monitor.on_sdo = self._link.notify
        self._link.handler = self._monitor.take
        self._events, self._supervision = self._monitor.events, self._monitor.supervision
        self._sdos: dict[int, Sdo] = {
            node: self._link.sdo(node, dictionaries) for node in self._monitor.counts
        }
        self.drives = Drives(
            vehicle, self._link, self._sdos.__getitem__, self._supervision, self._events, watchdog
        )
        self._recovery = Recovery(self._configure, self._events, inline=self._clock.inline)
        self._frozen = FrozenWatch(vehicle, self._events)
        self._nodes = sorted({encoder.node for encoder in vehicle.encoders})
        self._told: dict[int, dict[int, int]] = {}
        self._boots: dict[int, int] = {}
        self._patience = patience
        self._syncs = 0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()

    def configure(self) -> ConfigurationReport:
        """Forecast the bus load, configure every encoder, read it back, and start the nodes.

        Raises:
            BusOverload: the forecast leaves no room; nothing has been sent.
            NodeMissing, WrongDevice, MappingImpossible: a node is not as it must be.
            NotTaken, SdoRefused, SdoSilent: a dialogue failed.
            BusLost: the interface failed.
        """
        forecast = load.forecast(self.vehicle, HEARTBEAT_MS / 1000.0)
        load.check(forecast)
        nodes = tuple(self._configure(node) for node in self._nodes)
        self.vehicle = with_ranges(self.vehicle, nodes)
        self._monitor.begin(self.vehicle)
        if self._link.recorder is not None:
            self._link.recorder.use(self.vehicle)
        for one in nodes:
            self._start(one)
        return ConfigurationReport(nodes, forecast, self.vehicle)

    def enable(self) -> tuple[NodeConfiguration, ...]:
        """Configure and enable the drives; see `Drives.enable`."""
        return self.drives.enable()

    def command(self, wheel_speeds: Sequence[float]) -> tuple[float, ...]:
        """Command wheel speeds [rad/s] in the order of `vehicle.wheels`; see `Drives.command`."""
        return self.drives.command(wheel_speeds)

    def stop(self) -> None:
        """Command speed zero, at any time."""
        self.drives.stop()

    def samples(self) -> Iterator[Sample]:
        """Yield a sample per SYNC, for ever."""
        while True:
            yield self.cycle()

    def cycle(self) -> Sample:
        """Send SYNC when it is due and return the sample of its answers.

        Raises:
            BusError: a lost bus did not come back in time.
            BusLost: likewise, where the caller owns the bus.
        """
        assembler = self._monitor.assembler
        while True:
            try:
                self._until_due()
                self._send_sync()
                self._collect()
            except BusLost as lost:
                self._reconnect(lost)
            if assembler.is_open:
                sample = assembler.close()
                self._frozen.check(sample, self.drives.speeds if self.drives.is_enabled else None)
                return sample

    def report(self) -> DriverReport:
        """Return what has happened so far."""
        return make_report(self.vehicle, self._monitor, self._syncs, getattr(self._clock, "skipped", 0))

    def close(self) -> None:
        """Stop and disable the drives, end dialogues, and close the bus if it was given as a URL."""
        self.drives.disable()
        self._recovery.close()
        if self._url is not None:
            self._link.can_bus.shutdown()

    def _until_due(self) -> None:
        """Read the bus until SYNC is due and nothing is left of what came before it."""
        while (wait := self._clock.due()) > 0.0:
            self._link.pump(wait)
        take, receive = self._monitor.take, self._link.receive
        for _ in range(MAX_DRAIN):
            message = receive(0.0)
            if message is None:
                break
            take(message, self._link.arrival)
        now = self._clock.now()
        self._react(now)
        self.drives.tick(now)

    def _send_sync(self) -> None:
        at = self._clock.sync()
        try:
            self._link.send_sync(at)
        except BusLost as lost:
            self._events.add(at, None, f"SYNC could not be sent, tried again: {lost}")
            self._link.send_sync(at)
        self._monitor.assembler.begin(self._syncs, at)
        self._syncs += 1
        self._monitor.check(at)

    def _collect(self) -> None:
        """Read the bus until all awaited PDOs have come, or the window is over and the bus is read out."""
        assembler, take, receive = self._monitor.assembler, self._monitor.take, self._link.receive
        for _ in range(MAX_DRAIN):
            if assembler.is_complete:
                break
            left = self._clock.remaining()
            message = receive(max(left, 0.0))
            if message is not None:
                take(message, self._link.arrival)
            elif left <= 0.0:
                break
        end = time.monotonic() + SETTLE
        while (
            not assembler.is_settled and (left := min(end - time.monotonic(), self._clock.remaining())) > 0.0
        ):
            self._link.pump(left)

    def _react(self, now: float) -> None:
        """Have restarted nodes configured again and stop the wheels where a drive is out."""
        supervision = self._supervision
        while supervision.restarted:
            node = supervision.restarted.pop()
            self._monitor.assembler.restarted(node)
            self.drives.dropped(node, now)
            if node in self._nodes:
                self._recovery.request(node, now)
        while supervision.lost:
            self.drives.dropped(supervision.lost.pop(), now)
        if self._recovery.is_busy and (done := self._recovery.poll(now)) is not None:
            self._recovered(done, now)

    def _recovered(self, done: NodeConfiguration, now: float) -> None:
        changed = f"{len(done.changed)} objects set anew" if done.changed else "nothing had changed"
        self._events.add(now, done.node, f"configured again ({changed}) and started")
        for index in WATCHED_OBJECTS:
            before, after = self._told[done.node].get(index), done.told.get(index)
            if before != after:
                self._events.add(
                    now, done.node, f"{index:04X}h was {before}, is {after}: preset, or another device?"
                )
        self._start(done)
        if self._supervision.nodes[done.node].boots != self._boots[done.node]:
            self._recovery.request(done.node, now)

    def _configure(self, node: int) -> NodeConfiguration:
        self._boots[node] = self._supervision.nodes[node].boots
        return configure_node(self._sdos[node], self.vehicle, self._link.nmt_command)

    def _start(self, one: NodeConfiguration) -> None:
        self._told[one.node] = one.told
        for cob_id, length in one.lengths.items():
            self._monitor.assembler.expect_length(cob_id, length)
        self._link.nmt_command(NMT_START, one.node)
        self._supervision.started(one.node, one.heartbeat)
        self._monitor.assembler.await_again(one.node)

    def _reconnect(self, lost: BusLost) -> None:
        """Open a lost bus again, with longer and longer pauses, and give every node its configuration.

        Raises:
            BusError: it does not come back within `patience`.
            BusLost: the bus is the caller's.
        """
        before = self._clock.now()
        self._events.add(before, None, str(lost))
        if self._url is None:
            raise lost
        with contextlib.suppress(can.CanError, OSError):
            self._link.can_bus.shutdown()
        self._link.replace_bus(self._reopen(self._url, lost))
        away = self._clock.now() - before
        self._events.add(before + away, None, f"bus opened again after {away:.1f} s")
        self._supervision.pause(away)
        self._monitor.assembler.skip(int(away / self.vehicle.bus.sync_period))
        for node in self._nodes:
            self._recovery.request(node, before + away)
        for drive in self.vehicle.drives:  # they have missed our heartbeat
            self.drives.dropped(drive.node, before + away)

    def _reopen(self, url: str, lost: BusLost) -> can.BusABC:
        delay, waited = FIRST_DELAY, 0.0
        while waited < self._patience:
            self._clock.sleep(delay)
            waited += delay
            try:
                return open_bus(url)
            except BusError:
                delay = min(2.0 * delay, LONGEST_DELAY)
        raise BusError(url, f"lost ({lost.cause}), and not back within {self._patience:g} s")
