"""Configures a node by SDO so that its PDOs answer SYNC as `vehicle.toml` says, and reads all of it back."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.driver.configuration import NodeConfiguration
from omnimate.driver.errors import MappingImpossible
from omnimate.driver.heartbeat import set_heartbeat
from omnimate.driver.identity import check_identity, read_encoder
from omnimate.driver.network import NMT_PRE_OPERATIONAL, SYNC_ID
from omnimate.driver.notes import Notes
from omnimate.driver.pdo_mapping import Entry, holds, length, plan, position_objects
from omnimate.driver.pdo_parameters import TPDO, PdoSetting, read_pdos, switch_off, write_pdo
from omnimate.driver.wrap_range import choose_range

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from omnimate.driver.sdo import Sdo
    from omnimate.vehicle.parameters import Channel, Encoder, VehicleParameters

ON_SYNC = 1  # transmission type: an answer to every SYNC
GENERATES_SYNC = 1 << 30
PREFERRED_TPDO = (1, 0, 2, 3)  # TPDO2 is the synchronous one of most encoders


def configure_node(
    sdo: Sdo, vehicle: VehicleParameters, nmt: Callable[[int, int], None]
) -> NodeConfiguration:
    """Configure the encoders of one node; it is left pre-operational where something had to be changed.

    Args:
        sdo: Objects of the node.
        vehicle: Vehicle whose encoders the node holds.
        nmt: Sends an NMT command to a node: command specifier, node id.

    Raises:
        NodeMissing: The node does not answer.
        WrongDevice: The node is another device than `vehicle.toml` states.
        MappingImpossible: The PDOs of the node cannot carry the fields of `vehicle.toml`.
        NotTaken: The node confirmed a value and kept another one.
        SdoRefused: The node aborts a transfer.
        SdoSilent: The node stops answering.
    """
    encoders = [encoder for encoder in vehicle.encoders if encoder.node == sdo.node]
    names = tuple(encoder.channel for encoder in encoders)
    is_encoder = encoders[0].profile == "cia406"
    notes = Notes()
    check_identity(sdo, names, encoders[0], notes)
    encoder_objects = read_encoder(sdo, encoders, notes) if is_encoder else {}
    reported = sdo.find(0x6002) if is_encoder else None
    choices = {encoder.channel: choose_range(encoder, reported) for encoder in encoders}
    notes.remarks += [remark for _, remark in choices.values()]
    heartbeat = set_heartbeat(sdo, notes)
    _listen_to_sync(sdo, notes)
    lengths = _set_pdos(sdo, vehicle, encoders, nmt, notes)
    return NodeConfiguration(
        sdo.node,
        names,
        tuple(notes.read),
        tuple(notes.changed),
        tuple(notes.remarks),
        {channel: chosen for channel, (chosen, _) in choices.items()},
        lengths,
        heartbeat,
        encoder_objects,
    )


def _listen_to_sync(sdo: Sdo, notes: Notes) -> None:
    """Have the node take 080h for SYNC, and not produce SYNC itself."""
    cob_id = sdo.find(0x1005)
    if cob_id is None or (cob_id & 0x7FF == SYNC_ID and not cob_id & GENERATES_SYNC):
        return
    sdo.put(0x1005, 0, SYNC_ID)
    notes.changed.append(f"COB-ID SYNC 1005h: {cob_id:08X}h to {SYNC_ID:08X}h")


def _set_pdos(
    sdo: Sdo,
    vehicle: VehicleParameters,
    encoders: Sequence[Encoder],
    nmt: Callable[[int, int], None],
    notes: Notes,
) -> dict[int, int]:
    """Set every TPDO that the node's encoders need; return their lengths [bytes] by COB-ID."""
    settings = {setting.base: setting for setting in read_pdos(sdo, TPDO)}
    notes.read += [setting.in_words() for setting in settings.values()]
    objects = position_objects(encoders)
    chosen = choose_pdos(sdo.node, {encoder.cob_id for encoder in encoders}, settings)
    lengths = {}
    for cob_id, old in chosen.items():
        carried = [encoder for encoder in encoders if encoder.cob_id == cob_id]
        setting = old
        if not _is_right(old, cob_id, carried, objects):
            nmt(NMT_PRE_OPERATIONAL, sdo.node)
            setting = write_pdo(sdo, old, cob_id, ON_SYNC, plan(carried, objects))
            notes.changed.append(setting.in_words())
        lengths[cob_id] = length(setting.entries)
    used = {setting.base for setting in chosen.values()}
    spare = [setting for base, setting in settings.items() if base not in used]
    _switch_off_spare(sdo, vehicle, encoders[0], spare, notes)
    return lengths


def choose_pdos(node: int, cob_ids: set[int], settings: dict[int, PdoSetting]) -> dict[int, PdoSetting]:
    """Return which TPDO shall carry each COB-ID: the one that has it already, else the first that is free.

    Args:
        node: CANopen node id.
        cob_ids: COB-IDs that `vehicle.toml` states for this node.
        settings: TPDOs of the device, by the index of their communication parameters.

    Raises:
        MappingImpossible: The device has fewer TPDOs than are needed.
    """
    chosen = {setting.cob_id: setting for setting in settings.values() if setting.cob_id in cob_ids}
    taken = {setting.base for setting in chosen.values()}
    free = [TPDO + n for n in PREFERRED_TPDO if TPDO + n in settings and TPDO + n not in taken]
    for cob_id in sorted(cob_ids - chosen.keys()):
        if not free:
            raise MappingImpossible(
                node,
                f"no TPDO is left for COB-ID {cob_id:03X}h; the device has {len(settings)}, expected "
                f"{len(cob_ids)} or more",
                "put several channels of this node into one cob_id in vehicle.toml",
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


def _switch_off_spare(
    sdo: Sdo, vehicle: VehicleParameters, encoder: Encoder, spare: Sequence[PdoSetting], notes: Notes
) -> None:
    """Switch off TPDOs that would only fill the bus, or whose COB-ID belongs to another node."""
    used = {encoder.cob_id for encoder in vehicle.encoders} | {drive.cob_id for drive in vehicle.drives}
    for setting in spare:
        if not setting.is_valid:
            continue
        if encoder.profile == "cia406" or setting.cob_id in used:
            switch_off(sdo, setting)
            notes.changed.append(f"{setting.name} {setting.cob_id:03X}h switched off")
        else:
            notes.remarks.append(
                f"{setting.name} {setting.cob_id:03X}h stays on; its frames count as unknown"
            )
