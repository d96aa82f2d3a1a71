"""The objects of CiA 301, 406 and 402 that the driver reads and writes, so that no EDS is needed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from canopen.objectdictionary import ObjectDictionary, ODArray, ODRecord, ODVariable
from canopen.objectdictionary.datatypes import INTEGER8, INTEGER32, UNSIGNED8, UNSIGNED16, UNSIGNED32

if TYPE_CHECKING:
    from collections.abc import Mapping

PDO_NUMBERS = range(4)  # of the predefined connection set

VARIABLES: Mapping[int, tuple[str, int]] = {
    0x1000: ("Device type", UNSIGNED32),
    0x1001: ("Error register", UNSIGNED8),
    0x1005: ("COB-ID SYNC", UNSIGNED32),
    0x1006: ("Communication cycle period", UNSIGNED32),
    0x1017: ("Producer heartbeat time", UNSIGNED16),
    0x1019: ("Synchronous counter overflow value", UNSIGNED8),
    0x6000: ("Operating parameters", UNSIGNED16),
    0x6001: ("Measuring units per revolution", UNSIGNED32),
    0x6002: ("Total measuring range", UNSIGNED32),
    0x6004: ("Position value", UNSIGNED32),
    0x6007: ("Abort connection option code", UNSIGNED16),
    0x6040: ("Controlword", UNSIGNED16),
    0x6041: ("Statusword", UNSIGNED16),
    0x6060: ("Modes of operation", INTEGER8),
    0x6061: ("Modes of operation display", INTEGER8),
    0x6064: ("Position actual value", INTEGER32),
    0x60FF: ("Target velocity", INTEGER32),
    0x6500: ("Operating status", UNSIGNED16),
    0x6501: ("Singleturn resolution", UNSIGNED32),
    0x6502: ("Number of revolutions", UNSIGNED16),
    0x6509: ("Offset value", INTEGER32),
    0x650B: ("Serial number", UNSIGNED32),
}
ARRAYS: Mapping[int, tuple[str, int]] = {
    0x1016: ("Consumer heartbeat time", UNSIGNED32),
    0x1018: ("Identity object", UNSIGNED32),
    0x6020: ("Position value for multi-sensor devices", INTEGER32),
    **{base + n: ("PDO mapping", UNSIGNED32) for base in (0x1600, 0x1A00) for n in PDO_NUMBERS},
}
# Entries by name, where there are several; the last two bits of a PDO's index are its number.
ENTRIES: Mapping[int, tuple[str, ...]] = {
    0x1018: ("Vendor-ID", "Product code", "Revision number", "Serial number"),
    0x6020: tuple(f"Position {number}" for number in range(1, 5)),
    0x1600: tuple(f"Object {number}" for number in range(1, 9)),
    0x1A00: tuple(f"Object {number}" for number in range(1, 9)),
}
PDO_RECORD = {1: UNSIGNED32, 2: UNSIGNED8, 3: UNSIGNED16, 5: UNSIGNED16}


def standard_dictionary() -> ObjectDictionary:
    """Return an object dictionary with the objects of `VARIABLES`, `ARRAYS` and the first four PDOs."""
    dictionary = ObjectDictionary()  # type: ignore[no-untyped-call]  # canopen is typed in part
    for index, (name, data_type) in VARIABLES.items():
        dictionary.add_object(_variable(name, index, 0, data_type))
    for index, (name, data_type) in ARRAYS.items():
        array = ODArray(f"{name} {index:04X}h", index)
        array.add_member(_variable("Highest sub-index", index, 0, UNSIGNED8))
        for subindex, entry in enumerate(ENTRIES.get(index & 0xFFFC, ("Entry",)), start=1):
            array.add_member(_variable(entry, index, subindex, data_type))
        dictionary.add_object(array)
    for index in (base + n for base in (0x1400, 0x1800) for n in PDO_NUMBERS):
        record = ODRecord(f"PDO communication {index:04X}h", index)
        for subindex, data_type in PDO_RECORD.items():
            record.add_member(_variable(f"Entry {subindex}", index, subindex, data_type))
        dictionary.add_object(record)
    return dictionary


def _variable(name: str, index: int, subindex: int, data_type: int) -> ODVariable:
    variable = ODVariable(name, index, subindex)
    variable.data_type = data_type
    return variable
