"""The signals of PDOs, by the mapping of a device or a log and the names in the object dictionary."""

from __future__ import annotations

from typing import TYPE_CHECKING

from canopen.objectdictionary.datatypes import FLOAT_TYPES, SIGNED_TYPES

from omnimate.driver.canopen.dictionary import standard_dictionary
from omnimate.driver.canopen.object_values import default_of
from omnimate.files.logs.seen_mapping import mapped_objects
from omnimate.files.logs.signals import Signal

if TYPE_CHECKING:
    from collections.abc import Mapping

    from canopen.objectdictionary import ObjectDictionary

    from omnimate.files.logs.seen_mapping import Mapped

PDO_PARAMETERS = range(0x1400, 0x1C00)


def default_objects(dictionary: ObjectDictionary, node: int) -> dict[tuple[int, int, int], int]:
    """Return the PDO parameters that a device has after power-on, by node, index and sub-index."""
    objects: dict[tuple[int, int, int], int] = {}
    for index in PDO_PARAMETERS:
        if index in dictionary:
            for subindex in range(65):
                value = default_of(dictionary, index, subindex)
                if value is not None:
                    objects[node, index, subindex] = value
    return objects


def mapped_signals(
    objects: Mapping[tuple[int, int, int], int], dictionaries: Mapping[int, ObjectDictionary]
) -> dict[int, tuple[Signal, ...]]:
    """Return the signals of each PDO, by identifier, to which `EXTENDED_KEY` is added for 29 bits.

    Args:
        objects: PDO parameters by node, index and sub-index.
        dictionaries: Object dictionaries by node; objects of other nodes have the names of the profiles.
    """
    standard = standard_dictionary()
    return {
        cob_id: tuple(_signal(entry, dictionaries.get(entry.node, standard)) for entry in carried)
        for cob_id, carried in mapped_objects(objects).items()
    }


def _signal(entry: Mapped, dictionary: ObjectDictionary) -> Signal:
    variable = dictionary.get_variable(entry.object, entry.subindex)
    place = f"{entry.object:04X}h" + (f":{entry.subindex:02X}" if entry.subindex else "")
    name = f"{entry.node}.{place}"
    if variable is None:
        return Signal(name, entry.start_bit, entry.bits)
    kind = variable.data_type
    words = str(variable.qualname).replace("Entry", "").strip(". ")
    return Signal(
        f"{name} {words}" if words else name,
        entry.start_bit,
        entry.bits,
        signed=kind in SIGNED_TYPES,
        is_float=kind in FLOAT_TYPES and entry.bits in {32, 64},
    )
