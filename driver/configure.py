"""Configures a node by SDO so that its PDOs answer SYNC as `vehicle.toml` says, and reads all of it back."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from driver.errors import MappingImpossible, NotTaken, SdoRefused
from driver.identity import Notes, check_identity, choose_range, read_encoder
from driver.link import NMT_PRE_OPERATIONAL, SYNC_ID
from driver.mapping import Entry, holds, length, plan, position_objects
from driver.pdo import TPDO, PdoSetting, read_pdos, switch_off, write_pdo

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from driver.load import BusLoad
    from driver.sdo import Sdo
    from vehicle.parameters import Channel, Encoder, VehicleParameters

HEARTBEAT_MS = 500
HEARTBEAT_BOUNDS_MS = (100, 2000)  # a heartbeat within them is left as it is
ON_SYNC = 1  # transmission type: an answer to every SYNC
GENERATES_SYNC = 1 << 30
PREFERRED_TPDO = (1, 0, 2, 3)  # TPDO2 is the synchronous one of most encoders


@dataclass(frozen=True, slots=True)
class NodeConfiguration:
    """What was found at one node, what was changed, and what an operator should read.

    Attributes:
        node: CANopen node id.
        names: channels that it measures, or wheels that it drives.
        found: as it was.
        changed: by the driver; empty where all was right.
        remarks: in words.
        ranges: by which each channel is unwrapped.
        lengths: bytes of each of its PDOs, by COB-ID.
        heartbeat: period [s]; None where it has none.
        told: what a CiA 406 encoder tells of itself, by index: offset 6509h, serial number 650Bh, ...
    """

    node: int
    names: tuple[str, ...]
    found: tuple[str, ...] = ()
    changed: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()
    ranges: dict[Channel, int] = field(default_factory=dict)
    lengths: dict[int, int] = field(default_factory=dict)
    heartbeat: float | None = None
    told: dict[int, int] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class ConfigurationReport:
    """All nodes.

    Attributes:
        nodes: in order of their id.
        load: forecast of the bus load.
        vehicle: with the ranges by which the counters are unwrapped.
    """

    nodes: tuple[NodeConfiguration, ...]
    load: BusLoad
    vehicle: VehicleParameters

    def rows(self) -> list[tuple[str, str, str, str]]:
        """Return (node, channels, kind, what) for each line to print."""
        rows = [("bus", "", "load", self.load.in_words())]
        for one in self.nodes:
            for kind, lines in (("found", one.found), ("changed", one.changed), ("remark", one.remarks)):
                rows += [(str(one.node), ", ".join(one.names), kind, line) for line in lines]
        return rows


def with_ranges(vehicle: VehicleParameters, nodes: Sequence[NodeConfiguration]) -> VehicleParameters:
    """Return the vehicle with the chosen range of each encoder whose own says something else."""
    ranges = {channel: chosen for one in nodes for channel, chosen in one.ranges.items()}
    encoders = tuple(
        one
        if ranges.get(one.channel, one.wrap_range) == one.wrap_range
        else replace(one, range=ranges[one.channel])
        for one in vehicle.encoders
    )
    return vehicle if encoders == vehicle.encoders else replace(vehicle, encoders=encoders)


def configure_node(
    sdo: Sdo, vehicle: VehicleParameters, nmt: Callable[[int, int], None]
) -> NodeConfiguration:
    """Configure the encoders of one node; it is left pre-operational where something had to be changed.

    Args:
        sdo: of the node.
        vehicle: whose encoders it holds.
        nmt: sends an NMT command to a node.

    Raises:
        NodeMissing: nobody answers.
        WrongDevice: it is another device.
        MappingImpossible: its PDOs cannot carry the fields.
        NotTaken, SdoRefused, SdoSilent: the dialogue failed.
    """
    encoders = [one for one in vehicle.encoders if one.node == sdo.node]
    names = tuple(one.channel for one in encoders)
    notes = Notes()
    check_identity(sdo, names, encoders[0], notes)
    told = read_encoder(sdo, encoders, notes) if encoders[0].profile == "cia406" else {}
    said = sdo.find(0x6002) if encoders[0].profile == "cia406" else None
    choices = {one.channel: choose_range(one, said) for one in encoders}
    notes.remarks += [remark for _, remark in choices.values()]
    heartbeat = set_heartbeat(sdo, notes)
    _listen_to_sync(sdo, notes)
    lengths = _set_pdos(sdo, vehicle, encoders, nmt, notes)
    return NodeConfiguration(
        sdo.node,
        names,
        tuple(notes.found),
        tuple(notes.changed),
        tuple(notes.remarks),
        {channel: chosen for channel, (chosen, _) in choices.items()},
        lengths,
        heartbeat,
        told,
    )


def set_heartbeat(sdo: Sdo, notes: Notes) -> float | None:
    """Have the node produce a heartbeat; return its period [s], None where it has none.

    Raises:
        SdoRefused, SdoSilent: the dialogue failed.
    """
    found = sdo.find(0x1017)
    if found is None:
        notes.remarks.append("no heartbeat (1017h); its silence shows in its PDOs alone")
        return None
    least, most = HEARTBEAT_BOUNDS_MS
    if least <= found <= most:
        notes.found.append(f"heartbeat 1017h = {found} ms")
        return found / 1000.0
    try:
        sdo.put(0x1017, 0, HEARTBEAT_MS)
    except (SdoRefused, NotTaken) as error:
        notes.remarks.append(f"heartbeat stays at {found} ms: {error}")
        return found / 1000.0 or None
    notes.changed.append(f"heartbeat 1017h: {found} ms to {HEARTBEAT_MS} ms")
    return HEARTBEAT_MS / 1000.0


def _listen_to_sync(sdo: Sdo, notes: Notes) -> None:
    """Have the node take 080h for SYNC, and not produce SYNC itself."""
    found = sdo.find(0x1005)
    if found is None or (found & 0x7FF == SYNC_ID and not found & GENERATES_SYNC):
        return
    sdo.put(0x1005, 0, SYNC_ID)
    notes.changed.append(f"COB-ID SYNC 1005h: {found:08X}h to {SYNC_ID:08X}h")


def _set_pdos(
    sdo: Sdo,
    vehicle: VehicleParameters,
    encoders: Sequence[Encoder],
    nmt: Callable[[int, int], None],
    notes: Notes,
) -> dict[int, int]:
    """Set every TPDO that the node's encoders need; return their lengths by COB-ID."""
    settings = {setting.base: setting for setting in read_pdos(sdo, TPDO)}
    notes.found += [setting.in_words() for setting in settings.values()]
    objects = position_objects(encoders)
    chosen = choose_pdos(sdo.node, {one.cob_id for one in encoders}, settings)
    lengths = {}
    for cob_id, old in chosen.items():
        mine = [one for one in encoders if one.cob_id == cob_id]
        setting = old
        if not _is_right(old, cob_id, mine, objects):
            nmt(NMT_PRE_OPERATIONAL, sdo.node)
            setting = write_pdo(sdo, old, cob_id, ON_SYNC, plan(mine, objects))
            notes.changed.append(setting.in_words())
        lengths[cob_id] = length(setting.entries)
    spare = [
        setting for base, setting in settings.items() if base not in {one.base for one in chosen.values()}
    ]
    _quiet(sdo, vehicle, encoders[0], spare, notes)
    return lengths


def choose_pdos(node: int, cob_ids: set[int], settings: dict[int, PdoSetting]) -> dict[int, PdoSetting]:
    """Return which TPDO shall carry each COB-ID: the one that has it already, else the first that is free.

    Raises:
        MappingImpossible: the device has too few.
    """
    chosen = {one.cob_id: one for one in settings.values() if one.cob_id in cob_ids}
    taken = {one.base for one in chosen.values()}
    free = [TPDO + n for n in PREFERRED_TPDO if TPDO + n in settings and TPDO + n not in taken]
    for cob_id in sorted(cob_ids - chosen.keys()):
        if not free:
            raise MappingImpossible(
                node, f"it has {len(settings)} TPDOs; none is left for COB-ID {cob_id:03X}h"
            )
        chosen[cob_id] = settings[free.pop(0)]
    return chosen


def _is_right(
    setting: PdoSetting, cob_id: int, encoders: Sequence[Encoder], objects: dict[Channel, Entry]
) -> bool:
    return (
        setting.is_valid
        and setting.cob_id == cob_id
        and setting.transmission == ON_SYNC
        and holds(setting.entries, encoders, objects)
    )


def _quiet(
    sdo: Sdo, vehicle: VehicleParameters, encoder: Encoder, spare: Sequence[PdoSetting], notes: Notes
) -> None:
    """Switch off TPDOs that would only fill the bus, or whose COB-ID belongs to another node."""
    ours = {one.cob_id for one in vehicle.encoders} | {drive.cob_id for drive in vehicle.drives}
    for setting in spare:
        if not setting.is_valid:
            continue
        if encoder.profile == "cia406" or setting.cob_id in ours:
            switch_off(sdo, setting)
            notes.changed.append(f"{setting.name} {setting.cob_id:03X}h switched off")
        else:
            notes.remarks.append(
                f"{setting.name} {setting.cob_id:03X}h stays on; its frames count as unknown"
            )
