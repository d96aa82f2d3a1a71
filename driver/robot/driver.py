"""Produces SYNC, reads the encoders, supervises the nodes, and recovers what can be recovered."""

from __future__ import annotations

import contextlib
import math
import time
from dataclasses import replace
from typing import TYPE_CHECKING, Self

import can

from omnimate.driver.bus.bus import open_bus
from omnimate.driver.bus.clock import Clock, WallClock
from omnimate.driver.canopen.dcf import description_remarks
from omnimate.driver.canopen.network import BusNetwork
from omnimate.driver.errors import BusError, BusLost, in_one_line
from omnimate.driver.robot.bus_load import check_load, forecast_load
from omnimate.driver.robot.configure import ConfigurationReport, with_target_bits
from omnimate.driver.robot.drives import Drives
from omnimate.driver.robot.encoder_nodes import EncoderNodes
from omnimate.driver.robot.events import Trouble
from omnimate.driver.robot.flight_recorder import FlightRecorder
from omnimate.driver.robot.monitor import Monitor
from omnimate.driver.robot.recovery import Recovery
from omnimate.driver.robot.report import DriverReport, make_report
from omnimate.driver.robot.stalled_wheels import StallDetector

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from pathlib import Path

    from omnimate.driver.canopen.eds import Eds
    from omnimate.driver.canopen.network import FrameSink
    from omnimate.driver.canopen.node_setup import NodeConfiguration
    from omnimate.driver.canopen.sdo import Sdo
    from omnimate.vehicle.parameters import VehicleParameters
    from omnimate.vehicle.sample import Sample

SHORT_WAIT = 0.01  # [s] of host time for PDOs that do not answer reliably
MAX_DRAIN = 20_000  # frames read before a SYNC; more than two seconds of a full 1 Mbit/s bus
REACTION = 0.01  # [s] between two checks of the drives while no frame comes
# [s] between two checks from which on the host was busy, so that missing frames are no silence of a node
HOST_STALL = 0.05
GIVE_UP = 10.0  # [s] without an answer of an encoder, after which an operator must look at it
FIRST_DELAY, LONGEST_DELAY = 0.1, 5.0  # [s] before a lost bus is opened again


class Driver:
    """The master of one vehicle's bus; use it as a context manager, in one thread.

    Attributes:
        drives: Drives of the wheels.
    """

    def __init__(
        self,
        vehicle: VehicleParameters,
        bus: can.BusABC | str,
        *,
        clock: Clock | None = None,
        recorder: FrameSink | None = None,
        descriptions: Mapping[int, Eds] | None = None,
        patience: float = 30.0,
        watchdog: float = 0.2,
        flight_recorder: Path | str | None = None,
    ) -> None:
        """Open the bus where it is given as a URL; nothing is sent yet.

        Args:
            vehicle: Vehicle as its owner believes it to be.
            bus: URL, which is opened again when the bus is lost, or a bus that the caller owns.
            clock: Pace of SYNC; the wall clock where it is None.
            recorder: Gets every frame that is sent or received; None for none. Frames that it cannot record
                are one event of the report, with their number.
            descriptions: What EDS and DCF files describe, by node id; none is needed.
            patience: Time in which a lost bus must come back [s].
            watchdog: Time without a command after which the wheels are stopped [s].
            flight_recorder: Folder in which a `FlightRecorder` writes the last minute before a fault;
                None for none.

        Raises:
            BusError: The URL's bus cannot be opened.
        """
        self._url = bus if isinstance(bus, str) else None
        self._clock: Clock = clock or WallClock(vehicle.bus.sync_period)
        self._monitor = Monitor(vehicle, self._clock)
        self._flight: FlightRecorder | None = None
        if flight_recorder is not None:
            self._flight = FlightRecorder(flight_recorder, vehicle, self._monitor.events, recorder)
        self._network = BusNetwork(
            open_bus(bus, vehicle.bus.bitrate) if isinstance(bus, str) else bus,
            self._clock,
            recorder if self._flight is None else self._flight,
        )
        self._monitor.on_sdo = self._network.notify
        self._network.handler = self._monitor.take
        self._network.on_unrecorded = self._monitor.events.unrecorded
        self._events, self._supervision = self._monitor.events, self._monitor.supervision
        self._descriptions = descriptions or {}
        dictionaries = {node: eds.dictionary for node, eds in self._descriptions.items()}
        self._sdos: dict[int, Sdo] = {
            node: self._network.sdo(node, dictionaries, vehicle.bus.sdo_timeout)
            for node in self._monitor.counts
        }
        self.drives = Drives(vehicle, self._network, self._sdos.__getitem__, self._monitor, watchdog)
        self._network.on_wait = self.drives.keep_alive
        self._encoders = EncoderNodes(vehicle, self._monitor, self._sdos, self._network.nmt_command)
        self._recovery = Recovery(self._encoders.configure, self._events, inline=self._clock.inline)
        self._wheels = StallDetector(vehicle)
        self._patience, self._checked = patience, self._clock.now()
        self._end = math.inf  # time after which a lost bus is not waited for [s]
        self._syncs = 0

    @property
    def vehicle(self) -> VehicleParameters:
        """The vehicle, after `configure` with the ranges that its encoders report."""
        return self._encoders.vehicle

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()

    def configure(self) -> ConfigurationReport:
        """Forecast the bus load, configure every encoder, read it back, and start the nodes.

        One that booted meanwhile is configured again in the next cycles.

        Raises:
            BusOverload: The forecast leaves no room; nothing has been sent.
            NodeMissing: A node does not answer.
            WrongDevice: A node is another device than `vehicle.toml` states.
            MappingImpossible: The PDOs of a node cannot carry the fields of `vehicle.toml`.
            NotTaken: A node confirmed a value and kept another one.
            SdoRefused: A node aborts a transfer.
            SdoSilent: A node stops answering.
            BusLost: The interface failed.
        """
        load = forecast_load(self.vehicle)
        check_load(load)
        nodes = self._encoders.configure_all()
        for node in nodes:
            node.remarks += self._remarks(node.node)
        self._monitor.begin(self.vehicle)
        if self._network.recorder is not None:
            self._network.recorder.use(self.vehicle)
        for node in nodes:
            if not self._encoders.start(node):
                self._recovery.request(node.node, self._clock.now())
        return ConfigurationReport(nodes, load, self.vehicle)

    def enable(self) -> tuple[NodeConfiguration, ...]:
        """Configure and enable the drives; see `Drives.enable`."""
        remarks = {
            drive.node: self._remarks(drive.node)
            for drive in self.vehicle.drives
            if drive.node not in self._encoders.ids and self._sdos[drive.node].answers()
        }
        nodes = self.drives.enable()
        vehicle = with_target_bits(self.vehicle, self.drives.target_bits)
        if vehicle is not self.vehicle and self._network.recorder is not None:
            self._network.recorder.use(vehicle)
        self._encoders.vehicle = vehicle
        for node in nodes:
            node.remarks += remarks.get(node.node, ())
        return nodes

    def command(self, wheel_speeds: Sequence[float]) -> tuple[float, ...]:
        """Command wheel speeds [rad/s] in the order of `vehicle.wheels`; see `Drives.command`."""
        return self.drives.command(wheel_speeds)

    def stop(self) -> None:
        """Command speed zero, at any time."""
        self.drives.stop()

    def end_after(self, seconds: float | None) -> None:
        """Wait for a lost bus until so long from now at most [s]; None for as long as `patience`."""
        self._end = math.inf if seconds is None else self._clock.now() + seconds

    def samples(self) -> Iterator[Sample]:
        """Yield a sample per SYNC, without end; errors as of `cycle`."""
        while True:
            yield self.cycle()

    def cycle(self) -> Sample:
        """Send SYNC when it is due and return the sample of its answers.

        Raises:
            BusError: A lost bus did not come back in time.
            BusLost: The interface failed, and the caller owns the bus.
        """
        try:
            return self._cycle()
        except Exception as error:
            if self._flight is not None:
                what = f"the driver cannot go on: {in_one_line(error)}"
                self._flight.event(self._clock.now(), None, what, is_fault=True)
            raise

    def _cycle(self) -> Sample:
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
                self._check_wheels(sample)
                return sample

    def report(self) -> DriverReport:
        """Return the counters, events and gaps so far."""
        report = make_report(self.vehicle, self._monitor, self._syncs, self._clock.skipped)
        return replace(report, troubles=self.drives.troubles)

    def close(self) -> None:
        """Stop and disable the drives, end dialogues, and close the bus if it was given as a URL."""
        self.drives.disable()
        self._recovery.close()
        if self._flight is not None:
            self._flight.close(self._clock.now())
        if self._url is not None:
            self._network.can_bus.shutdown()

    def _remarks(self, node: int) -> tuple[str, ...]:
        """Return where the EDS or DCF of a node differs from the node or the vehicle."""
        if node not in self._descriptions:
            return ()
        encoders = [encoder for encoder in self.vehicle.encoders if encoder.node == node]
        return description_remarks(self._sdos[node], self._descriptions[node], encoders)

    def _until_due(self) -> None:
        """Read the bus until SYNC is due and all frames that came before it are read."""
        while (wait := self._clock.due()) > 0.0:
            self._network.pump(min(wait, REACTION))
            self._check_drives()
        take, receive = self._monitor.take, self._network.receive
        for _ in range(MAX_DRAIN):
            message = receive(0.0)
            if message is None:
                break
            take(message, self._network.arrival)
        self._check_drives()
        now = self._clock.now()
        self._recover(now)
        self.drives.tick(now)
        if self._flight is not None:
            self._flight.poll(now, self.drives.speeds)

    def _check_drives(self) -> None:
        """Stop all wheels where a drive is in trouble."""
        now, troubles = self._clock.now(), self._supervision.troubles
        if now - self._checked > max(HOST_STALL, 2.0 * self.vehicle.bus.sync_period):
            self._monitor.pause(now - self._checked, now)
        self._checked = now
        self._monitor.check(now)
        while troubles:
            trouble = troubles.pop(0)
            self.drives.halt(trouble)
            if trouble.has_restarted and trouble.node in self._encoders.ids:
                self._recovery.request(trouble.node, now)

    def _send_sync(self) -> None:
        at = self._clock.sync()
        try:
            self._network.send_sync(at)
        except BusLost as lost:
            self._events.add(at, None, f"SYNC could not be sent, tried again: {lost.cause}")
            self._network.send_sync(at)
        self._monitor.assembler.begin(self._syncs, at)
        self._syncs += 1
        self._monitor.synced(at)

    def _collect(self) -> None:
        """Read the bus until all awaited PDOs have come, or the window is over and the bus is read out."""
        assembler, take, receive = self._monitor.assembler, self._monitor.take, self._network.receive
        for _ in range(MAX_DRAIN):
            if assembler.is_complete:
                break
            left = self._clock.remaining()
            message = receive(min(max(left, 0.0), REACTION))
            if message is not None:
                take(message, self._network.arrival)
            elif left <= 0.0:
                break
            else:
                self._check_drives()
        end = time.monotonic() + SHORT_WAIT
        for _ in range(MAX_DRAIN):
            if assembler.is_settled:
                break
            left = min(end - time.monotonic(), self._clock.remaining())
            message = receive(max(left, 0.0))  # what has come is read, however late it is
            if message is not None:
                take(message, self._network.arrival)
            elif left <= 0.0:
                break

    def _check_wheels(self, sample: Sample) -> None:
        """Log the wheels that have stalled, and stop all where one has stalled against its command."""
        speeds = self.drives.speeds if self.drives.is_enabled else None
        for wheel in self._wheels.check(sample, speeds):
            node = self.vehicle.encoder(wheel).node
            should = "the truck moves" if speeds is None else "it is commanded to turn"
            what = f"{wheel}: count stands still while {should}: encoder frozen, or wheel blocked"
            self._events.add(sample.time, node, what)
            self.drives.stop_for_stall(wheel, sample.time)

    def _recover(self, now: float) -> None:
        """Configure nodes again that have restarted, or that have not answered SYNC for long."""
        assembler = self._monitor.assembler
        for node in assembler.take_silent():
            if assembler.never_answered(node):
                self._monitor.report_unanswered(node, "check its PDO mapping and 1005h")
            elif assembler.silence(node) >= GIVE_UP:
                what = f"has not answered SYNC for {GIVE_UP:g} s: check its power and its cable"
                self._monitor.trouble(what, node)
            # also where its heartbeat is lost: a node that restarted unheard produces none until it is set
            if not self._recovery.is_waiting(node):
                self._recovery.request(node, now)
        if self._recovery.is_busy:
            configuration = self._recovery.poll(now)
            if configuration is not None and not self._encoders.start_again(configuration, now):
                self._recovery.request(configuration.node, now)

    def _reconnect(self, lost: BusLost) -> None:
        """Open a lost bus again, with longer and longer pauses, and have every node configured again.

        Raises:
            BusError: The bus does not come back within `patience`, or before the end.
            BusLost: The caller owns the bus.
        """
        before = self._clock.now()
        self._events.add(before, None, str(lost), is_fault=True)
        if self._url is None:
            raise lost
        with contextlib.suppress(can.CanError, OSError):
            self._network.can_bus.shutdown()
        self._network.replace_bus(self._reopen(self._url, lost))
        away = self._clock.now() - before
        self._events.add(before + away, None, f"bus opened again after {away:.1f} s")
        self._monitor.pause(away, before + away)
        for node in self._encoders.ids:
            self._recovery.request(node, before + away)
        self.drives.halt(Trouble(before + away, None, "the bus was lost, and with it the driver's heartbeat"))

    def _reopen(self, url: str, lost: BusLost) -> can.BusABC:
        delay, waited = FIRST_DELAY, 0.0
        patience = min(self._patience, self._end - self._clock.now())
        while waited < patience:
            pause = min(delay, patience - waited)
            self._clock.sleep(pause)
            waited += pause
            try:
                return open_bus(url, self.vehicle.bus.bitrate)
            except BusError:
                delay = min(2.0 * delay, LONGEST_DELAY)
        raise BusError(
            url,
            f"lost ({lost.cause}), and not back within {max(patience, 0.0):.3g} s; "
            "check the adapter, its cable and the power of the bus",
        )


def open_driver(
    vehicle: VehicleParameters,
    bus: str,
    recorder: FrameSink | None = None,
    descriptions: Mapping[int, Eds] | None = None,
    flight_recorder: Path | str | None = None,
) -> tuple[Driver, ConfigurationReport]:
    """Return a driver whose encoders are configured and started, and the report of their configuration.

    Args:
        vehicle: The robot as its `vehicle.toml` describes it.
        bus: URL of the bus, such as `socketcan://can0`.
        recorder: Receives every frame; None for none.
        descriptions: What EDS and DCF files describe, by node id; see `load_descriptions`.
        flight_recorder: Folder for the last minute before a fault; see `Driver`.

    Raises:
        DriverError: The bus cannot be opened, or a node is not as it must be; the bus is closed again.
    """
    driver = Driver(
        vehicle, bus, recorder=recorder, descriptions=descriptions, flight_recorder=flight_recorder
    )
    try:
        return driver, driver.configure()
    except BaseException:
        driver.close()
        raise
