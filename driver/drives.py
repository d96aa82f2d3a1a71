"""Wheel speeds to CiA 402 drives by RPDO: nothing moves before `enable`, nothing outlives its commander."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from driver.configure import NodeConfiguration, set_heartbeat
from driver.drive_states import disable_drive, enable_drive
from driver.errors import (
    BadCommand,
    BusLost,
    DriverError,
    MappingImpossible,
    NotEnabled,
    NotTaken,
    SdoRefused,
)
from driver.identity import Notes, check_identity
from driver.link import NMT_PRE_OPERATIONAL, NMT_START
from driver.mapping import Entry
from driver.pdo import RPDO, TPDO, PdoSetting, read_pdos, switch_off, write_pdo

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from driver.events import EventLog
    from driver.link import Link
    from driver.sdo import Sdo
    from driver.supervision import Supervision
    from vehicle.parameters import Drive, VehicleParameters

TARGET_VELOCITY = Entry(0x60FF, 0, 32)
STATUS_INHIBIT = 1000  # [100 us] between two status words
BY_EVENT = 254  # transmission types from here on are sent at every change
STATUS_WORD = Entry(0x6041, 0, 16)
ON_RECEPTION = 255  # transmission type: a target counts as soon as it comes
REFRESH = 0.1  # [s] between two RPDOs of an unchanged command, and between two heartbeats of ours
HEARTBEAT_TIMEOUT_MS = 500  # after which a drive misses our heartbeat, where it can
QUICK_STOP = 3  # abort connection option code 6007h
OPERATIONAL = b"\x05"
INT32 = 2**31 - 1


class Drives:
    """All drives of a vehicle, enabled and commanded together.

    Attributes:
        is_enabled: commands are taken.
        reason: why not, where they are not.
        speeds: last command [rad/s] in the order of `vehicle.wheels`.
        limited: commands that were slowed down to `vehicle.limits.speed`.
    """

    def __init__(
        self,
        vehicle: VehicleParameters,
        link: Link,
        sdo_of: Callable[[int], Sdo],
        supervision: Supervision,
        events: EventLog,
        watchdog: float,
    ) -> None:
        self.is_enabled = False
        self._is_alive = False  # our heartbeat has begun, and the drives watch it
        self.reason = "enable() has not been called"
        self.speeds = (0.0,) * len(vehicle.wheels)
        self.limited = 0
        self._vehicle, self._link, self._sdo_of = vehicle, link, sdo_of
        self._supervision, self._events, self._watchdog = supervision, events, watchdog
        self._drives = [vehicle.drive(wheel) for wheel in vehicle.wheels] if vehicle.drives else []
        self._radii = [vehicle.wheel_diameter(wheel) / 2.0 for wheel in vehicle.wheels]
        self._sent: list[int | None] = [None] * len(self._drives)
        self._commanded = self._refreshed = -math.inf
        used = supervision.nodes
        self._own_node = next(node for node in range(127, 0, -1) if node not in used)

    def enable(self) -> tuple[NodeConfiguration, ...]:
        """Configure all drives and bring them to operation enabled at speed zero.

        Raises:
            NotEnabled: the vehicle has no drives.
            DriveError: a drive does not reach a state.
            NodeMissing, MappingImpossible, NotTaken, SdoRefused, SdoSilent: a dialogue failed.
        """
        if not self._drives:
            raise NotEnabled("vehicle.toml states no [[drive]] for each wheel")
        self._is_alive = True
        self._heartbeat()
        nodes = tuple(self._prepare(drive) for drive in self._drives)
        for drive in self._drives:
            self._heartbeat()
            enable_drive(self._sdo_of(drive.node), self._link.pump)
        self.is_enabled, self.reason = True, ""
        self._commanded = self._link.clock.now()
        self._send_all((0.0,) * len(self._drives))
        return nodes

    def command(self, speeds: Sequence[float]) -> tuple[float, ...]:
        """Command wheel speeds [rad/s] in the order of `vehicle.wheels`; return them as limited.

        Where a wheel would be faster than `vehicle.limits.speed`, all are slowed down by the same factor,
        so that the path stays the same.

        Raises:
            NotEnabled: `enable` has not been called, or a drive has dropped out since.
            BadCommand: not one finite number for each wheel.
        """
        if not self.is_enabled:
            raise NotEnabled(self.reason)
        if len(speeds) != len(self._drives) or not all(map(math.isfinite, speeds)):
            raise BadCommand(f"{list(speeds)}: expected {len(self._drives)} finite wheel speeds [rad/s]")
        self._commanded = self._link.clock.now()
        self.speeds = self._limit(speeds)
        self._send_changed()
        return self.speeds

    def tick(self, now: float) -> None:
        """Refresh what is commanded, or stop where nobody commands any more; once per SYNC at `now` [s].

        Raises:
            BusLost: the interface failed.
        """
        if not self._is_alive:
            return
        if now - self._commanded > self._watchdog and any(self.speeds):
            self._events.add(now, None, f"no command for {self._watchdog:g} s: wheels stopped")
            self.speeds = (0.0,) * len(self._drives)
        if now - self._refreshed >= REFRESH:
            self._refreshed = now
            self._heartbeat()
            self._sent = [None] * len(self._drives)
        self._send_changed()

    def stop(self) -> None:
        """Command speed zero, at any time; a bus that is gone is noted, and the drives' own watchdogs act."""
        if not self._is_alive:
            return
        try:
            self._send_all((0.0,) * len(self._drives))
        except BusLost as lost:
            self._events.add(self._link.clock.now(), None, f"stop could not be sent: {lost}")

    def disable(self) -> None:
        """Stop, and take the torque away; what fails is noted."""
        if not self._is_alive:
            return
        self.stop()
        self._is_alive = self.is_enabled = False
        self.reason = "they were disabled"
        for drive in self._drives:
            try:
                disable_drive(self._sdo_of(drive.node))
            except DriverError as error:
                self._events.add(self._link.clock.now(), drive.node, f"could not be disabled: {error}")

    def dropped(self, node: int, now: float) -> None:
        """Stop all wheels because one of their drives is out; only `enable` starts them again."""
        if self.is_enabled and any(drive.node == node for drive in self._drives):
            self.stop()
            self.is_enabled, self.reason = False, f"the drive of node {node} dropped out"
            self._events.add(now, node, "its drive dropped out: all wheels stopped, enable() is needed")

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
            target = target_velocity(drive, speed)
            if target != self._sent[number]:
                self._link.send_message(drive.cob_id, target.to_bytes(4, "little", signed=True))
                self._sent[number] = target

    def _heartbeat(self) -> None:
        self._link.send_message(0x700 + self._own_node, OPERATIONAL)

    def _prepare(self, drive: Drive) -> NodeConfiguration:
        """Map the RPDO, set heartbeats both ways, and start the node."""
        sdo, notes = self._sdo_of(drive.node), Notes()
        check_identity(sdo, (f"drive of {drive.wheel}",), None, notes)
        self._link.nmt_command(NMT_PRE_OPERATIONAL, drive.node)
        self._map(sdo, drive, notes)
        self._watch_status(sdo, notes)
        heartbeat = set_heartbeat(sdo, notes)
        _watch_us(sdo, self._own_node, notes)
        self._link.nmt_command(NMT_START, drive.node)
        self._supervision.started(drive.node, heartbeat)
        return NodeConfiguration(
            drive.node,
            (f"drive of {drive.wheel}",),
            tuple(notes.found),
            tuple(notes.changed),
            tuple(notes.remarks),
            heartbeat=heartbeat,
        )

    def _map(self, sdo: Sdo, drive: Drive, notes: Notes) -> None:
        settings = read_pdos(sdo, RPDO)
        notes.found += [setting.in_words() for setting in settings]
        if not settings:
            raise MappingImpossible(drive.node, f"it has no RPDO for COB-ID {drive.cob_id:03X}h")
        old = next((one for one in settings if one.cob_id == drive.cob_id), settings[0])
        if not _is_right(old, drive):
            written = write_pdo(sdo, old, drive.cob_id, ON_RECEPTION, ((TARGET_VELOCITY,),))
            notes.changed.append(written.in_words())

    def _watch_status(self, sdo: Sdo, notes: Notes) -> None:
        """Listen to the TPDOs that tell the drive's status word; other TPDOs are left alone."""
        encoders = {one.cob_id for one in self._vehicle.encoders}
        for setting in read_pdos(sdo, TPDO):
            if not setting.is_valid or setting.cob_id in encoders:
                continue
            if setting.entries[:1] == (STATUS_WORD,):
                self._supervision.status_words[setting.cob_id] = sdo.node
                _inhibit(sdo, setting, notes)
            else:
                notes.remarks.append(f"{setting.in_words()}; its frames count as unknown")


def target_velocity(drive: Drive, speed: float) -> int:
    """Return 60FFh [counts/s] for a wheel speed [rad/s]; it saturates at 32 bits."""
    counts = drive.sign * speed * drive.counts_per_turn / (2.0 * math.pi)
    return round(max(-INT32, min(INT32, counts)))


def _is_right(setting: PdoSetting, drive: Drive) -> bool:
    return (
        setting.is_valid
        and setting.cob_id == drive.cob_id
        and setting.transmission == ON_RECEPTION
        and setting.entries == (TARGET_VELOCITY,)
    )


def _inhibit(sdo: Sdo, setting: PdoSetting, notes: Notes) -> None:
    """Keep a status word that changes with every command from filling the bus; faults come by EMCY too."""
    if setting.inhibit is None or setting.inhibit >= STATUS_INHIBIT or setting.transmission < BY_EVENT:
        return
    switch_off(sdo, setting)
    try:
        sdo.put(setting.base, 3, STATUS_INHIBIT)
    except (SdoRefused, NotTaken) as error:
        notes.remarks.append(f"inhibit time of {setting.name} stays: {error}")
    else:
        notes.changed.append(
            f"inhibit time of {setting.name}: {setting.inhibit} to {STATUS_INHIBIT} x 100 us"
        )
    sdo.write(setting.base, 1, setting.raw)


def _watch_us(sdo: Sdo, own_node: int, notes: Notes) -> None:
    """Have the drive stop by itself when our heartbeat ends, where it can."""
    for index, subindex, value in (
        (0x1016, 1, own_node << 16 | HEARTBEAT_TIMEOUT_MS),
        (0x6007, 0, QUICK_STOP),
    ):
        try:
            sdo.put(index, subindex, value)
        except (SdoRefused, NotTaken) as error:
            notes.remarks.append(f"the drive's own watchdog is incomplete: {error}")
        else:
            notes.changed.append(f"{index:04X}h:{subindex:02X} = {value:X}h")
