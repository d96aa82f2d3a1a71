"""Wheel speeds to CiA 402 drives by RPDO: only after `enable`, and only as long as commands come."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from omnimate.driver.canopen.cia402 import (
    ENABLE_OPERATION,
    QUICK_STOP,
    SHUTDOWN,
    disable_drive,
    enable_drive,
    planned_pdo,
)
from omnimate.driver.errors import BadCommand, BusLost, DriverError, DrivesStopped, NotEnabled
from omnimate.driver.robot.drive_configuration import configure_drive
from omnimate.driver.robot.events import Trouble
from omnimate.files.logs.canopen_words import (
    HEARTBEAT,
    NMT_PRE_OPERATIONAL,
    NMT_START,
    OPERATIONAL,
    STOPPED,
    error_register_in_words,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from omnimate.driver.canopen.cia402 import TargetPdo
    from omnimate.driver.canopen.network import BusNetwork
    from omnimate.driver.canopen.node_setup import NodeConfiguration
    from omnimate.driver.canopen.sdo import Sdo
    from omnimate.driver.robot.monitor import Monitor
    from omnimate.driver.robot.status_words import StatusSource
    from omnimate.vehicle.parameters import Channel, Drive, VehicleParameters

# [s] between two RPDOs of an unchanged command, and between two heartbeats of the driver: a fifth of
# `HEARTBEAT_TIMEOUT_MS`, so that one lost frame stops no drive
REFRESH = 0.1
MAX_TROUBLES = 8  # a fault is soon followed by more; the first ones are the cause
INT32 = 2**31 - 1


class Drives:
    """All drives of a vehicle, enabled and commanded together."""

    def __init__(
        self,
        vehicle: VehicleParameters,
        network: BusNetwork,
        sdo_of: Callable[[int], Sdo],
        monitor: Monitor,
        watchdog: float,
    ) -> None:
        self.is_enabled = False  # whether commands are taken
        self._is_alive = False  # the driver's heartbeat has begun, and the drives monitor it from then on
        self._is_disabled = True
        self.troubles: tuple[Trouble, ...] = ()  # what stopped all wheels since the drives were last enabled
        self._reason = "enable() has not been called"
        self.speeds = (0.0,) * len(vehicle.wheels)  # last command [rad/s] in the order of `vehicle.wheels`
        self.limited = 0  # commands that were slowed down to `vehicle.limits.speed`
        self._vehicle, self._network, self._sdo_of = vehicle, network, sdo_of
        self._events, self._supervision = monitor.events, monitor.supervision
        self._status_words = monitor.status_words
        self._watchdog = watchdog
        self._drives = [vehicle.drive(wheel) for wheel in vehicle.wheels] if vehicle.drives else []
        self._radii = [vehicle.wheel_diameter(wheel) / 2.0 for wheel in vehicle.wheels]
        self._pdos = {drive.node: planned_pdo(drive) for drive in self._drives}
        self._control = SHUTDOWN  # control word in the PDOs that carry one: no torque unless enabled
        self._sent: list[tuple[TargetPdo, int, int] | None] = [None] * len(self._drives)
        self._commanded = self._refreshed = self._last_heartbeat = -math.inf
        self._nodes = {drive.node: f"drive of {drive.wheel}" for drive in self._drives}
        used = self._supervision.nodes
        self._driver_node = next(node for node in range(127, 0, -1) if node not in used)

    def enable(self) -> tuple[NodeConfiguration, ...]:
        """Configure all drives and bring them to operation enabled at speed zero.

        Raises:
            NotEnabled: The vehicle has no drives.
            DriveError: A drive does not reach a state of CiA 402.
            NodeMissing: A drive does not answer.
            MappingImpossible: A drive cannot map the target velocity.
            NotTaken: A drive confirmed a value and kept another one.
            SdoRefused: A drive aborts a transfer.
            SdoSilent: A drive stops answering.
            BusLost: The interface failed.
        """
        if not self._drives:
            raise NotEnabled("vehicle.toml has no [[drive]]", "add one for each wheel to vehicle.toml")
        self._is_alive, self._is_disabled, self._control = True, False, SHUTDOWN
        self._heartbeat()
        configured = [self._configure(drive) for drive in self._drives]
        answered: dict[StatusSource, float] = {}
        older: dict[int, int] = {}
        for _, source in configured:
            answered[source] = self._enable(source.node)
            older[source.node] = len(self._supervision.troubles)
        self._control = ENABLE_OPERATION
        self._forget_old_troubles(older)
        self.is_enabled, self.troubles = True, ()
        self._commanded = self._network.clock.now()
        self._send_all((0.0,) * len(self._drives))
        self._status_words.begin(answered, lambda node: self._sdo_of(node).ask(0x6041), self._commanded)
        return tuple(configuration for configuration, _ in configured)

    @property
    def target_bits(self) -> dict[int, int]:
        """First bit of 60FFh in the RPDO of each drive, by node id."""
        return {node: pdo.start_bit for node, pdo in self._pdos.items()}

    def command(self, speeds: Sequence[float]) -> tuple[float, ...]:
        """Command wheel speeds [rad/s] in the order of `vehicle.wheels`; return them as limited.

        Where a wheel would be faster than `vehicle.limits.speed`, all are slowed down by the same factor, so
        that the path stays the same. Raises BadCommand for what is not one finite number for each wheel,
        BusLost, and the errors of `require_enabled`.
        """
        self.require_enabled()
        if len(speeds) != len(self._drives) or not all(map(math.isfinite, speeds)):
            raise BadCommand(
                f"command {list(speeds)}: expected {len(self._drives)} finite wheel speeds [rad/s], "
                f"one for each of {', '.join(self._vehicle.wheels)}"
            )
        self._commanded = self._network.clock.now()
        self.speeds = self._limit(speeds)
        self._send_changed()
        return self.speeds

    def require_enabled(self) -> None:
        """Raise NotEnabled before `enable`, or DrivesStopped after a drive has stopped all wheels."""
        if self.troubles:
            raise DrivesStopped(self.troubles, self._nodes)
        if not self.is_enabled:
            raise NotEnabled(self._reason)

    def tick(self, now: float) -> None:
        """Send the command again, or stop where no command comes any more; once per SYNC at `now` [s].

        Raises BusLost.
        """
        if not self._is_alive:
            return
        if now - self._commanded > self._watchdog and any(self.speeds):
            what = f"no command for {self._watchdog:g} s: wheels stopped"
            self._events.add(now, None, what, is_fault=True)
            self.speeds = (0.0,) * len(self._drives)
        self.keep_alive()
        if now - self._refreshed >= REFRESH:
            self._refreshed = now
            self._sent = [None] * len(self._drives)
        self._send_changed()

    def keep_alive(self) -> None:
        """Send the driver's heartbeat where it is due, also while one drive lets the others wait.

        Raises BusLost.
        """
        if self._is_alive and self._network.clock.now() - self._last_heartbeat >= REFRESH:
            self._heartbeat()

    def stop(self) -> None:
        """Command speed zero, at any time; a lost bus is logged, and the drives' own watchdogs stop them."""
        if not self._is_alive:
            return
        try:
            self._send_all((0.0,) * len(self._drives))
        except BusLost as lost:
            self._events.add(self._network.clock.now(), None, f"stop could not be sent: {lost.cause}")

    def disable(self) -> None:
        """Stop, and take the torque away; what fails is logged. The heartbeat goes on."""
        if self._is_disabled:
            return
        self.stop()
        self._status_words.end()
        self.is_enabled, self._is_disabled, self._control = False, True, SHUTDOWN
        self._reason = "they were disabled"
        for drive in self._drives:
            try:
                disable_drive(self._sdo_of(drive.node))
            except DriverError as error:
                self._events.add(self._network.clock.now(), drive.node, f"could not be disabled: {error}")

    def stop_for_stall(self, wheel: Channel, now: float) -> None:
        """Stop all wheels because one has stalled against its command at `now` [s]."""
        if self.is_enabled:
            what = f"{wheel} is commanded and stands"
            self.halt(Trouble(now, self._vehicle.drive(wheel).node, what))

    def halt(self, trouble: Trouble) -> None:
        """Stop all wheels where a trouble is one of an enabled drive; only `enable` starts them again.

        Every drive gets speed zero by PDO, and then a quick stop by SDO, which reaches a drive that is not
        operational, too. No answer is awaited.
        """
        is_ours = trouble.node is None or trouble.node in self._nodes
        if not is_ours or not (self.is_enabled or self.troubles):
            return
        self.troubles = (*self.troubles, trouble)[:MAX_TROUBLES]
        if not self.is_enabled:
            return
        self.is_enabled = False
        self._control = QUICK_STOP
        self._status_words.end()
        self.stop()
        try:
            self._quick_stop()
        except BusLost as lost:
            self._events.add(trouble.time, None, f"quick stop could not be sent: {lost.cause}")
        what = "all wheels stopped; enable() is needed"
        self._events.add(trouble.time, trouble.node, what, is_fault=True)

    def _quick_stop(self) -> None:
        for node in self._nodes:
            if self._supervision.nodes[node].state == STOPPED:  # it has no SDO in this state
                self._network.nmt_command(NMT_PRE_OPERATIONAL, node)
            self._sdo_of(node).post(0x6040, 0, QUICK_STOP)

    def _forget_old_troubles(self, older: Mapping[int, int]) -> None:
        """Remove the troubles of each drive, `older` by node id, from before it was operation enabled.

        In that state there is no fault (CiA 402), and not every device sends EMCY 0000h once an error has
        gone. Errors that the error register still shows have been logged.
        """
        troubles = self._supervision.troubles
        troubles[:] = [
            trouble
            for number, trouble in enumerate(troubles)
            if trouble.has_restarted or trouble.node is None or number >= older.get(trouble.node, 0)
        ]

    def _forget_restarts(self, node: int) -> None:
        troubles = self._supervision.troubles
        troubles[:] = [trouble for trouble in troubles if trouble.node != node or not trouble.has_restarted]

    def _limit(self, speeds: Sequence[float]) -> tuple[float, ...]:
        limit = self._vehicle.limits.speed
        fastest = max(abs(speed) * radius for speed, radius in zip(speeds, self._radii, strict=True))
        if fastest <= limit * (1.0 + 1e-9):
            return tuple(speeds)
        self.limited += 1
        self._events.add(self._commanded, None, f"a command was slowed down to limits.speed = {limit:g} m/s")
        return tuple(speed * limit / fastest for speed in speeds)

    def _send_all(self, speeds: tuple[float, ...]) -> None:
        self.speeds = speeds
        self._sent = [None] * len(self._drives)
        self._send_changed()

    def _send_changed(self) -> None:
        for number, (drive, speed) in enumerate(zip(self._drives, self.speeds, strict=True)):
            wanted = self._pdos[drive.node], target_velocity(drive, speed), self._control
            if wanted != self._sent[number]:
                pdo, target, control = wanted
                self._network.send_message(drive.cob_id, pdo.data(target, control))
                self._sent[number] = wanted

    def _heartbeat(self) -> None:
        self._last_heartbeat = self._network.clock.now()
        self._network.send_message(HEARTBEAT + self._driver_node, bytes([OPERATIONAL]))

    def _configure(self, drive: Drive) -> tuple[NodeConfiguration, StatusSource]:
        """Configure a drive's node and start it; return what was changed, and where its status word is."""
        sdo = self._sdo_of(drive.node)

        def interrupt(command: int, node: int) -> None:
            """Send an NMT command; what the drive reported of its state before has no meaning any more."""
            self._supervision.interrupted(node)
            if all(encoder.node != node for encoder in self._vehicle.encoders):
                self._forget_restarts(node)
            self._network.nmt_command(command, node)

        configuration, source, self._pdos[drive.node] = configure_drive(
            sdo,
            drive,
            self._driver_node,
            {encoder.cob_id for encoder in self._vehicle.encoders},
            self._vehicle.bus.sync_period,
            interrupt,
        )
        self._status_words.expect(source)
        self._network.nmt_command(NMT_START, drive.node)
        self._supervision.started(drive.node, configuration.heartbeat)
        self._supervision.check_boots(drive.node, self._network.clock.now())
        return configuration, source

    def _enable(self, node: int) -> float:
        """Enable a drive, and log which error it still has; return how long it takes to answer [s]."""
        self._heartbeat()
        sdo, clock = self._sdo_of(node), self._network.clock
        enable_drive(sdo, self._network.pump)
        asked = clock.now()
        sdo.read(0x6041)
        answer = clock.now() - asked
        if register := sdo.find(0x1001):
            errors = error_register_in_words(register)
            what = f"is enabled, yet its error register 1001h = {register:02X}h says: {errors}"
            self._events.add(clock.now(), node, what)
        return answer


def target_velocity(drive: Drive, speed: float) -> int:
    """Return 60FFh [counts/s] for a wheel speed [rad/s]; it saturates at 32 bits."""
    counts = drive.sign * speed * drive.counts_per_turn / (2.0 * math.pi)
    return round(max(-INT32, min(INT32, counts)))
