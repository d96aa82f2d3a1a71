"""Configures a node by SDO so that its PDOs answer SYNC as `vehicle.toml` says, and reads all of it back.

What the nodes report, such as how each counter wraps, is put into the vehicle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from omnimate.driver.canopen.node_setup import (
    NodeConfiguration,
    check_identity,
    read_encoder,
    set_heartbeat,
)
from omnimate.driver.canopen.pdo_mapping import holds, length, plan, position_objects
from omnimate.driver.canopen.pdo_parameters import (
    TPDO,
    PdoSetting,
    Transmission,
    read_pdos,
    switch_off,
    write_pdo,
)
from omnimate.driver.errors import MappingImpossible, NotTaken, SdoRefused
from omnimate.files.logs.canopen_words import NMT_PRE_OPERATIONAL, SYNC_ID

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping, Sequence

    from omnimate.driver.canopen.sdo import Sdo
    from omnimate.driver.robot.bus_load import BusLoad
    from omnimate.vehicle.parameters import Encoder, VehicleParameters

# Transmission types (CiA 301, 7.5.2.37): an answer to every SYNC; by the event timer and at changes.
ON_SYNC, AT_EVENTS = 1, (255, 254)
GENERATES_SYNC = 1 << 30  # bit of 1005h (CiA 301, 7.5.2.5)
CONSUMES_SYNC = 1 << 31  # of CiA 301 before version 4; in some devices it stays set
MAX_TIMER = 0xFFFF  # of the event timer and the inhibit time, 16 bits each
PREFERRED_TPDO = (1, 0, 2, 3)  # TPDO2 is the synchronous one of most encoders


def configure_node(
    sdo: Sdo, vehicle: VehicleParameters, nmt: Callable[[int, int], None]
) -> NodeConfiguration:
    """Configure the encoders of one node; it is left pre-operational where something had to be changed.

    Only what differs is written. Where the configuration fails, all former values are written back. Raises
    NodeMissing, TwoDevices, WrongDevice, MappingImpossible, NotTaken, SdoRefused or SdoSilent.
    """
    encoders = [encoder for encoder in vehicle.encoders if encoder.node == sdo.node]
    configuration = NodeConfiguration(sdo.node, tuple(encoder.channel for encoder in encoders))
    check_identity(sdo, encoders[0], configuration)
    reported = None
    if encoders[0].profile == "cia406":
        read_encoder(sdo, encoders, configuration)
        reported = sdo.find(0x6002)
    for encoder in encoders:
        configuration.ranges[encoder.channel], reason = choose_range(encoder, reported)
        configuration.remarks.append(reason)
    with sdo.restoring():
        set_heartbeat(sdo, configuration)
        _set_sync(sdo, vehicle.bus.sync_period, configuration)
        for cob_id, pdo in _set_pdos(sdo, vehicle, encoders, nmt, configuration).items():
            configuration.lengths[cob_id] = length(pdo.entries)
            if pdo.transmission in AT_EVENTS:
                configuration.timed.add(cob_id)
    return configuration


def _set_sync(sdo: Sdo, period: float, configuration: NodeConfiguration) -> None:
    """Set the SYNC of the node to 080h without a counter, at this period [s], and not produced by itself.

    1019h can be changed while 1006h is 0 only (CiA 301). A node that has no period in 1006h gets none.
    """
    cob_id = sdo.find(0x1005)
    if cob_id is not None and (cob_id & 0x7FF != SYNC_ID or cob_id & GENERATES_SYNC):
        wanted = cob_id & CONSUMES_SYNC | SYNC_ID
        sdo.put(0x1005, 0, wanted)
        configuration.changed.append(f"COB-ID SYNC 1005h: {cob_id:08X}h to {wanted:08X}h")
    cycle, overflow = sdo.find(0x1006), sdo.find(0x1019)
    try:
        if overflow:
            if cycle:
                sdo.put(0x1006, 0, 0)
            sdo.put(0x1019, 0, 0)
            configuration.changed.append(
                f"SYNC counter 1019h: {overflow} to 0, because SYNC has no counter here"
            )
        microseconds = round(1e6 * period)
        if cycle and (sdo.put(0x1006, 0, microseconds) and cycle != microseconds):
            configuration.changed.append(f"SYNC period 1006h: {cycle} to {microseconds} us")
    except (SdoRefused, NotTaken) as error:
        configuration.remarks.append(f"expects another SYNC: {error.problem}")


def _set_pdos(
    sdo: Sdo,
    vehicle: VehicleParameters,
    encoders: Sequence[Encoder],
    nmt: Callable[[int, int], None],
    configuration: NodeConfiguration,
) -> dict[int, PdoSetting]:
    """Set every TPDO that the node's encoders need, and return them by COB-ID."""
    settings = {setting.base: setting for setting in read_pdos(sdo, TPDO)}
    configuration.read += [setting.in_words() for setting in settings.values()]
    objects = position_objects(encoders)
    carried = {
        cob_id: [encoder for encoder in encoders if encoder.cob_id == cob_id]
        for cob_id in sorted({encoder.cob_id for encoder in encoders})
    }
    fits = {
        cob_id: {base for base, setting in settings.items() if holds(setting.entries, fields, objects)}
        for cob_id, fields in carried.items()
    }
    chosen = choose_pdos(sdo.node, fits, settings)
    pdos = {}
    for cob_id, old in chosen.items():
        setting, is_mapped = old, old.base in fits[cob_id]
        if not (is_mapped and old.is_valid and (old.cob_id, old.transmission) == (cob_id, ON_SYNC)):
            nmt(NMT_PRE_OPERATIONAL, sdo.node)
            slots = None if is_mapped else plan(carried[cob_id], objects)
            setting = write_pdo(sdo, old, cob_id, _transmissions(vehicle.bus.sync_period), slots)
            _note_change(old, setting, vehicle.bus.sync_period, configuration)
        pdos[cob_id] = setting
    used = {setting.base for setting in chosen.values()}
    spare = [setting for base, setting in settings.items() if base not in used]
    _switch_off_spare(sdo, vehicle, encoders[0], spare, configuration)
    return pdos


def _transmissions(period: float) -> tuple[Transmission, ...]:
    """Return an answer to each SYNC, and for a device that refuses, two frames per period [s].

    With two, one at least comes between two SYNCs, however the device's clock runs.
    """
    half = period / 2.0
    inhibit, timer = (min(max(1, math.floor(half * per_second)), MAX_TIMER) for per_second in (1e4, 1e3))
    return (Transmission(ON_SYNC), *(Transmission(kind, inhibit, timer) for kind in AT_EVENTS))


def _note_change(
    old: PdoSetting, setting: PdoSetting, period: float, configuration: NodeConfiguration
) -> None:
    """Note what was changed in a PDO, and what an operator should know of how it is sent."""
    if setting != old:
        configuration.changed.append(setting.in_words())
    if setting.transmission == ON_SYNC:
        return
    timer = f"event timer {setting.timer} ms" if setting.timer else "no event timer: sent at changes only"
    configuration.remarks.append(
        f"{setting.name} refuses transmission type {ON_SYNC} (an answer to each SYNC): type "
        f"{setting.transmission} instead, {timer}; its counts are up to {1e3 * period:g} ms younger than SYNC"
    )


def choose_pdos(
    node: int, fits: Mapping[int, Collection[int]], settings: Mapping[int, PdoSetting]
) -> dict[int, PdoSetting]:
    """Return which TPDO shall carry each COB-ID.

    It is the one that has the COB-ID already, else a free one that is mapped already, else the first free;
    `fits` gives those that are mapped already by COB-ID. Raises MappingImpossible where the device has too
    few.
    """
    chosen = {setting.cob_id: setting for setting in settings.values() if setting.cob_id in fits}
    taken = {setting.base for setting in chosen.values()}
    free = [TPDO + n for n in PREFERRED_TPDO if TPDO + n in settings and TPDO + n not in taken]
    for cob_id in sorted(fits.keys() - chosen.keys()):
        if not free:
            raise MappingImpossible(
                node,
                f"no TPDO is left for COB-ID {cob_id:03X}h; the device has {len(settings)}, expected "
                f"{len(fits)} or more",
                "put several channels of this node into one cob_id in vehicle.toml",
            )
        base = next((base for base in free if base in fits[cob_id]), free[0])
        free.remove(base)
        chosen[cob_id] = settings[base]
    return chosen


def _switch_off_spare(
    sdo: Sdo,
    vehicle: VehicleParameters,
    encoder: Encoder,
    spare: Sequence[PdoSetting],
    configuration: NodeConfiguration,
) -> None:
    """Switch off TPDOs that would only fill the bus, or whose COB-ID belongs to another node."""
    used = {encoder.cob_id for encoder in vehicle.encoders} | {drive.cob_id for drive in vehicle.drives}
    for setting in spare:
        if not setting.is_valid:
            continue
        name = f"{setting.name} {setting.cob_id:03X}h"
        if encoder.profile != "cia406" and setting.cob_id not in used:
            configuration.remarks.append(f"{name} stays on; its frames count as unknown")
            continue
        try:
            switch_off(sdo, setting)
        except SdoRefused as refused:
            if setting.cob_id in used:
                raise
            configuration.remarks.append(f"{name} stays on, its frames count as unknown: {refused.problem}")
        else:
            configuration.changed.append(f"{name} switched off")


@dataclass(frozen=True, slots=True)
class ConfigurationReport:
    """The configuration of all nodes."""

    nodes: tuple[NodeConfiguration, ...]  # configuration of each node, in order of the node ids
    load: BusLoad  # forecast of the bus load
    vehicle: VehicleParameters  # the vehicle with the ranges by which the counters are unwrapped


def with_ranges(vehicle: VehicleParameters, nodes: Sequence[NodeConfiguration]) -> VehicleParameters:
    """Return the vehicle with the chosen range of each encoder whose range in `vehicle.toml` differs."""
    ranges = {channel: chosen for node in nodes for channel, chosen in node.ranges.items()}
    encoders = tuple(
        encoder
        if ranges.get(encoder.channel, encoder.wrap_range) == encoder.wrap_range
        else replace(encoder, range=ranges[encoder.channel])
        for encoder in vehicle.encoders
    )
    return vehicle if encoders == vehicle.encoders else replace(vehicle, encoders=encoders)


def with_target_bits(vehicle: VehicleParameters, bits: Mapping[int, int]) -> VehicleParameters:
    """Return the vehicle with the first bit of 60FFh in the RPDO of each drive, given by node id."""
    drives = tuple(replace(drive, start_bit=bits[drive.node]) for drive in vehicle.drives)
    return vehicle if drives == vehicle.drives else replace(vehicle, drives=drives)


def choose_range(encoder: Encoder, reported: int | None) -> tuple[int, str]:
    """Return the range by which a channel is unwrapped [counts], and the reason in words.

    6002h, None where the device has none, means N for some vendors, N - 1 for others, and 0 means 2**32 for
    one.
    """
    stated, full = encoder.wrap_range, 2**encoder.bits
    chosen = stated
    if reported is None:
        reason = f"wraps at {stated}; the device has no 6002h"
    elif reported == stated:
        reason = f"wraps at {stated}; 6002h says so and means N"
    elif reported == stated - 1:
        reason = f"wraps at {stated}; 6002h says {reported} and means N - 1"
    elif reported == 0 and full == 2**32 and encoder.range is None:
        chosen, reason = full, "wraps at 2**32; 6002h says 0"
    elif encoder.range is not None or not 1 < (guess := reported + reported % 2) <= full:
        reason = f"6002h says {reported}, but vehicle.toml {stated}, which is used: check it"
    else:
        chosen, means = guess, "N - 1" if reported % 2 else "N"
        reason = f"wraps at {guess}; 6002h says {reported}, taken for {means}; vehicle.toml says nothing"
    return chosen, f"{encoder.channel}: {reason}"
