"""The values that a DCF states for a device (ParameterValue, CiA 306): compared with it, or written.

The EDS or DCF that `vehicle.toml` names for a node is compared with the node and with `vehicle.toml`, too.
"""

from __future__ import annotations

import struct
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from canopen.objectdictionary import ObjectDictionaryError
from canopen.objectdictionary.datatypes import INTEGER_TYPES, SIGNED_TYPES

from omnimate.driver.canopen.eds import load_eds
from omnimate.driver.canopen.object_values import decode, kind_of, variables_of
from omnimate.driver.canopen.pdo_mapping import position_objects
from omnimate.driver.canopen.pdo_parameters import INVALID, MAPPING, RPDO
from omnimate.driver.errors import NotTaken, SdoRefused

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from canopen.objectdictionary import ObjectDictionary, ODVariable

    from omnimate.driver.canopen.eds import Eds
    from omnimate.driver.canopen.pdo_mapping import Entry
    from omnimate.driver.canopen.sdo import Sdo
    from omnimate.vehicle.parameters import Encoder, VehicleParameters

PDOS = range(RPDO, 0x1C00)  # communication and mapping parameters of all PDOs
NEVER_WRITTEN = frozenset({0x1010, 0x1011})  # signatures that store and restore
SYNC_PERIOD, SYNC_COUNTER = 0x1006, 0x1019  # the second can be changed while the first is 0 (CiA 301)
IS_WRITABLE = frozenset({"rw", "wo", "rww", "rwr"})
MAX_LISTED = 10  # differences from a DCF; `omnimate dcf compare` lists all
# What vehicle.toml and the driver decide, besides PDOs: SYNC, heartbeats, and how a drive is commanded.
OURS = frozenset({0x1005, 0x1006, 0x1016, 0x1017, 0x1019, 0x6007, 0x6040, 0x6060, 0x60FF})


@dataclass(frozen=True, slots=True)
class Difference:
    """An object that is not as the DCF states."""

    index: int
    subindex: int
    name: str  # name in the DCF
    stated: float | str  # value in the DCF
    found: float | str | None  # value in the device; None where it shows none
    problem: str = ""  # why it shows none, or does not take the value; empty where it does

    def in_words(self) -> str:
        """Return object, name and both values as a line."""
        found = "nothing" if self.found is None else self.found
        line = f"{self.index:04X}h:{self.subindex:02X} {self.name}: {found}, the DCF states {self.stated}"
        return f"{line} ({self.problem})" if self.problem else line


def stated_values(dictionary: ObjectDictionary) -> tuple[ODVariable, ...]:
    """Return the variables for which a DCF states a value of their type, by index and sub-index."""
    return tuple(variable for variable in variables_of(dictionary) if _bytes(variable) is not None)


def differences(
    sdo: Sdo,
    dictionary: ObjectDictionary,
    concerns: Callable[[int], bool] = lambda _index: True,
    progress: Callable[[int, int], None] = lambda _done, _total: None,
) -> Iterator[Difference]:
    """Yield the objects of a device that are not as a DCF states; raises SdoSilent.

    `progress` gets the number of objects that have been read, and how many there are.
    """
    stated = [variable for variable in stated_values(dictionary) if concerns(variable.index)]
    for number, variable in enumerate(stated, start=1):
        difference = _difference(sdo, dictionary, variable)
        progress(number, len(stated))
        if difference is not None:
            yield difference


def write_values(
    sdo: Sdo, dictionary: ObjectDictionary, wrong: Sequence[Difference]
) -> tuple[Difference, ...]:
    """Write what a DCF states and a device has otherwise; return the objects that still differ.

    The node must be pre-operational. A PDO is switched off while its parameters are written, and its entries
    are written while their number is 0 (CiA 301). What is read-only in the DCF, and the signatures in 1010h
    and 1011h, are not written. Raises SdoSilent.
    """
    numbers = {(variable.index, variable.subindex): variable for variable in stated_values(dictionary)}
    places = [(difference.index, difference.subindex) for difference in wrong]
    writer = _Writer(sdo, numbers)
    with writer.without_sync_period(places):
        for place in places:
            if place[0] not in PDOS and place[0] != SYNC_PERIOD:
                writer.write(place)
    if (SYNC_PERIOD, 0) in places:
        writer.write((SYNC_PERIOD, 0))
    for base in sorted({index & ~MAPPING for index, _ in places if index in PDOS}):
        writer.write_pdo(base)
    left = (_difference(sdo, dictionary, numbers[place]) for place in places)
    return tuple(
        replace(
            difference,
            problem=writer.problems.get((difference.index, difference.subindex), difference.problem),
        )
        for difference in left
        if difference is not None
    )


class _Writer:
    """Writes the values of a DCF; `problems` says by index and sub-index why some were not written."""

    def __init__(self, sdo: Sdo, variables: dict[tuple[int, int], ODVariable]) -> None:
        self.problems: dict[tuple[int, int], str] = {}
        self._sdo, self._variables = sdo, variables

    def write(self, place: tuple[int, int]) -> None:
        """Write an object as the DCF states it."""
        variable = self._variables[place]
        if variable.access_type not in IS_WRITABLE or variable.index in NEVER_WRITTEN:
            self.problems[place] = "not written: " + (variable.access_type or "no access")
            return
        data = _bytes(variable) or b""
        try:
            if variable.data_type in INTEGER_TYPES:
                self._sdo.put(*place, int.from_bytes(data, "little"))
            else:
                self._sdo.write_bytes(*place, data)
        except (SdoRefused, NotTaken) as error:
            self.problems[place] = error.problem

    def write_pdo(self, base: int) -> None:
        """Write all that the DCF states about a PDO."""
        before = self._sdo.find(base, 1)
        if before is not None and not before & INVALID:
            self._try_put(base, 1, before | INVALID)
        parameters = [place for place in self._variables if place[0] == base and place[1] > 1]
        entries = [place for place in self._variables if place[0] == base + MAPPING and place[1]]
        for place in parameters:
            self.write(place)
        if entries:
            self._try_put(base + MAPPING, 0, 0)
        for place in entries:
            self.write(place)
        if (base + MAPPING, 0) in self._variables:
            self.write((base + MAPPING, 0))
        elif entries:
            self._try_put(base + MAPPING, 0, len(entries))
        if (base, 1) in self._variables:
            self.write((base, 1))
        elif before is not None:
            self._try_put(base, 1, before)

    @contextmanager
    def without_sync_period(self, places: Sequence[tuple[int, int]]) -> Iterator[None]:
        """Set 1006h to 0 for this block where 1019h is to be written, and write it back afterwards."""
        before = self._sdo.find(SYNC_PERIOD) if (SYNC_COUNTER, 0) in places else None
        if before:
            self._try_put(SYNC_PERIOD, 0, 0)
        try:
            yield
        finally:
            if before:
                self._try_put(SYNC_PERIOD, 0, before)

    def _try_put(self, index: int, subindex: int, value: int) -> None:
        try:
            self._sdo.put(index, subindex, value)
        except (SdoRefused, NotTaken) as error:
            self.problems[index, subindex] = error.problem


def _difference(sdo: Sdo, dictionary: ObjectDictionary, variable: ODVariable) -> Difference | None:
    index, subindex = variable.index, variable.subindex
    data, kind = _bytes(variable) or b"", kind_of(dictionary, index, subindex)
    name, stated = str(variable.qualname), decode(data, kind)
    try:
        found = decode(sdo.read_bytes(index, subindex)[: len(data) or None], kind)
    except SdoRefused as refused:
        return Difference(index, subindex, name, stated, None, refused.problem)
    return None if found == stated else Difference(index, subindex, name, stated, found)


def _bytes(variable: ODVariable) -> bytes | None:
    """Return the stated value as it is sent; None where none is stated, or none that its type can hold."""
    value = variable.value
    if value is None:
        return None
    if variable.data_type in SIGNED_TYPES and value >> len(variable) - 1 == 1:  # such as 0xFFFFFFFF for -1
        value -= 1 << len(variable)
    try:
        return bytes(variable.encode_raw(value))
    except (ValueError, TypeError, struct.error, ObjectDictionaryError):
        return None


def load_descriptions(vehicle: VehicleParameters) -> dict[int, Eds]:
    """Return what the EDS and DCF files that a vehicle names describe, by node id; raises EdsError."""
    return {node: load_eds(path, node) for node, path in vehicle.eds_files.items()}


def description_remarks(sdo: Sdo, eds: Eds, encoders: Sequence[Encoder]) -> tuple[str, ...]:
    """Return remarks for an operator: where a node differs from its description; raises SdoSilent."""
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
