"""Configures one CiA 402 drive by SDO: its RPDO, its status word, and heartbeats both ways."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.driver.canopen.cia402 import TargetPdo, planned_pdo, takes_target
from omnimate.driver.canopen.node_setup import (
    DRIVE_HEARTBEAT_MS,
    NodeConfiguration,
    check_identity,
    set_heartbeat,
    wake,
)
from omnimate.driver.canopen.pdo_parameters import (
    RPDO,
    TPDO,
    PdoSetting,
    Transmission,
    read_pdo,
    read_pdos,
    switch_off,
    write_pdo,
)
from omnimate.driver.errors import MappingImpossible, NotTaken, SdoRefused
from omnimate.driver.robot.status_words import (
    BY_EVENT,
    LONGEST_INHIBIT,
    STATUS_WORD,
    StatusSource,
    status_source,
)
from omnimate.files.logs.canopen_words import NMT_PRE_OPERATIONAL

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    from omnimate.driver.canopen.sdo import Sdo
    from omnimate.vehicle.parameters import Drive

ON_RECEPTION = (255, 254)  # transmission types: a target counts as soon as it comes (CiA 301, 7.5.2.35)
HEARTBEAT_TIMEOUT_MS = 500  # [ms] in 1016h, after which a drive misses the driver's heartbeat
QUICK_STOP = 3  # abort connection option code 6007h: quick stop (CiA 402-2)


def configure_drive(
    sdo: Sdo,
    drive: Drive,
    driver_node: int,
    encoder_cob_ids: Collection[int],
    sync_period: float,
    nmt: Callable[[int, int], None],
) -> tuple[NodeConfiguration, StatusSource, TargetPdo]:
    """Map the RPDO of a drive, limit the rate of its status word, and set heartbeats both ways.

    The node is left pre-operational. Nothing is written that holds already. Where the configuration fails,
    everything is put back. The PDOs of encoders are left alone; SYNC comes every `sync_period` [s].

    Return what was read and changed, how the status word 6041h reaches the driver, and the RPDO. Raises
    NodeMissing, NotTaken, SdoRefused, SdoSilent, or MappingImpossible where no RPDO can carry the target
    velocity.
    """
    configuration = NodeConfiguration(drive.node, (f"drive of {drive.wheel}",), woken=wake(sdo, nmt))
    check_identity(sdo, None, configuration)
    nmt(NMT_PRE_OPERATIONAL, drive.node)
    with sdo.restoring():
        target = _map_target(sdo, drive, configuration)
        settings = [
            _limited(sdo, setting, encoder_cob_ids, configuration) for setting in read_pdos(sdo, TPDO)
        ]
        set_heartbeat(sdo, configuration, DRIVE_HEARTBEAT_MS, DRIVE_HEARTBEAT_MS)
        _set_watchdog(sdo, driver_node, configuration)
    heartbeat = configuration.heartbeat
    has_fast_heartbeat = heartbeat is not None and 1000.0 * heartbeat <= DRIVE_HEARTBEAT_MS
    source = status_source(drive.node, settings, sync_period if has_fast_heartbeat else None)
    return configuration, source, target


def _map_target(sdo: Sdo, drive: Drive, configuration: NodeConfiguration) -> TargetPdo:
    """Have an RPDO take the target velocity 60FFh under the drive's COB-ID, and return it.

    One that takes the control word 6040h, too, stays as it is.
    """
    settings = read_pdos(sdo, RPDO)
    configuration.read += [setting.in_words() for setting in settings]
    if not settings:
        raise MappingImpossible(
            drive.node,
            f"it has no RPDO (1400h to 1403h); expected one for COB-ID {drive.cob_id:03X}h",
            "check node and cob_id of the [[drive]] in vehicle.toml, or use a drive with RPDOs",
        )
    old = next((setting for setting in settings if setting.cob_id == drive.cob_id), settings[0])
    is_mapped = takes_target(old.entries)
    target = TargetPdo(drive.cob_id, old.entries) if is_mapped else planned_pdo(drive)
    if target.start_bit != drive.start_bit:
        configuration.remarks.append(
            f"{old.name} carries 60FFh from bit {target.start_bit} on; say so by start_bit in vehicle.toml"
        )
    if is_mapped and old.is_valid and old.cob_id == drive.cob_id and old.transmission in ON_RECEPTION:
        return target
    choices = (*map(Transmission, ON_RECEPTION), Transmission(old.transmission))
    slots = None if is_mapped else [(entry,) for entry in target.entries]
    written = write_pdo(sdo, old, drive.cob_id, choices, slots)
    if written != old:
        configuration.changed.append(written.in_words())
    if written.transmission not in ON_RECEPTION:
        configuration.remarks.append(
            f"{written.name} keeps transmission type {written.transmission}: a target counts from SYNC on"
        )
    return target


def _limited(
    sdo: Sdo, setting: PdoSetting, encoder_cob_ids: Collection[int], configuration: NodeConfiguration
) -> PdoSetting:
    """Return a TPDO, where it carries the status word with its rate limited; others stay as they are."""
    if not setting.is_valid or setting.cob_id in encoder_cob_ids:
        return setting
    if STATUS_WORD not in setting.entries:
        configuration.remarks.append(f"{setting.in_words()}; its frames count as unknown")
        return setting
    if setting.transmission < BY_EVENT or setting.inhibit is None or 0 < setting.inhibit <= LONGEST_INHIBIT:
        return setting
    return _inhibited(sdo, setting, configuration)


def _inhibited(sdo: Sdo, setting: PdoSetting, configuration: NodeConfiguration) -> PdoSetting:
    """Set the inhibit time of a status word, so that it does not fill the bus, and a fault still shows."""
    try:
        switch_off(sdo, setting)
        sdo.put(setting.base, 3, LONGEST_INHIBIT)
    except (SdoRefused, NotTaken) as error:
        configuration.remarks.append(f"inhibit time of {setting.name} stays: {error.problem}")
    else:
        configuration.changed.append(
            f"inhibit time of {setting.name}: {setting.inhibit} to {LONGEST_INHIBIT} x 100 us"
        )
    if sdo.find(setting.base, 1) != setting.raw:
        sdo.write(setting.base, 1, setting.raw)
    return read_pdo(sdo, setting.base) or setting


def _set_watchdog(sdo: Sdo, driver_node: int, configuration: NodeConfiguration) -> None:
    """Have the drive stop by itself when the driver's heartbeat ends (1016h, 6007h), where it can."""
    for index, subindex, value in (
        (0x1016, 1, driver_node << 16 | HEARTBEAT_TIMEOUT_MS),
        (0x6007, 0, QUICK_STOP),
    ):
        try:
            if sdo.put(index, subindex, value):
                configuration.changed.append(f"{index:04X}h:{subindex:02X} = {value:X}h")
        except (SdoRefused, NotTaken) as error:
            configuration.remarks.append(f"the drive's own watchdog is incomplete: {error.problem}")
