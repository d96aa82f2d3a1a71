"""Compares the EDS or DCF of a node, which `vehicle.toml` names, with the node and with `vehicle.toml`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from canopen.objectdictionary.datatypes import SIGNED_TYPES

from omnimate.driver.canopen.dcf import PDOS, differences
from omnimate.driver.canopen.eds import load_eds
from omnimate.driver.canopen.pdo_mapping import position_objects

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from omnimate.driver.canopen.eds import Eds
    from omnimate.driver.canopen.pdo_mapping import Entry
    from omnimate.driver.canopen.sdo import Sdo
    from omnimate.vehicle.parameters import Encoder, VehicleParameters

MAX_LISTED = 10  # differences from a DCF; `omnimate dcf compare` lists all
# What vehicle.toml and the driver decide, besides PDOs: SYNC, heartbeats, and how a drive is commanded.
OURS = frozenset({0x1005, 0x1006, 0x1016, 0x1017, 0x1019, 0x6007, 0x6040, 0x6060, 0x60FF})


def load_descriptions(vehicle: VehicleParameters) -> dict[int, Eds]:
    """Return what the EDS and DCF files that a vehicle names describe, by node id.

    Raises:
        EdsError: A file cannot be read.
    """
    return {node: load_eds(path, node) for node, path in vehicle.eds_files.items()}


def description_remarks(sdo: Sdo, eds: Eds, encoders: Sequence[Encoder]) -> tuple[str, ...]:
    """Return remarks for an operator: where a node differs from its description.

    Args:
        sdo: Objects of the node.
        eds: What its EDS or DCF describes, for this node id.
        encoders: Encoders of the node.

    Raises:
        SdoSilent: The node stops answering.
    """
    remarks = [_of_identity(sdo, eds)]
    objects = position_objects(encoders)
    remarks += [_of_position(encoder, objects[encoder.channel], eds) for encoder in encoders]
    remarks += _of_values(sdo, eds)
    return tuple(f"{eds.path.name}: {remark}" for remark in remarks if remark)


def _of_identity(sdo: Sdo, eds: Eds) -> str:
    information = eds.dictionary.device_information
    for subindex, name, stated in (
        (1, "vendor", information.vendor_number),
        (2, "product", information.product_number),
    ):
        actual = sdo.find(0x1018, subindex) if stated else None
        if actual not in {None, stated}:
            return (
                f"it describes {name} {stated:X}h, the device is of {name} {actual:X}h; is it the right file?"
            )
    return ""


def _of_position(encoder: Encoder, entry: Entry, eds: Eds) -> str:
    """Return how the description of the position object differs from vehicle.toml; empty if it agrees."""
    variable = eds.dictionary.get_variable(entry.index, entry.subindex)
    what = f"{encoder.channel}: {entry.index:04X}h:{entry.subindex:02X}"
    if variable is None:
        return f"{what} is not in it; let `object` in vehicle.toml name the position"
    if len(variable) != encoder.bits:
        return f"{what} has {len(variable)} bits; vehicle.toml says {encoder.bits}"
    is_signed = variable.data_type in SIGNED_TYPES
    if is_signed != encoder.signed and encoder.channel == "link":
        return f"{what} is {'' if is_signed else 'un'}signed; vehicle.toml says the contrary"
    return ""


def _of_values(sdo: Sdo, eds: Eds) -> Iterator[str]:
    """Yield where the device differs from its DCF, except in objects that vehicle.toml and the driver set."""
    others = differences(sdo, eds.dictionary, lambda index: index not in OURS and index not in PDOS)
    for number, difference in enumerate(others):
        if number == MAX_LISTED:
            yield "and more; `omnimate dcf compare` lists all"
            return
        yield difference.in_words()
