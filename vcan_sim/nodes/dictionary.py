"""Object dictionaries: the entries of an EDS file."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

import canopen
from canopen.objectdictionary import ODVariable
from canopen.objectdictionary.datatypes import INTEGER_TYPES, SIGNED_TYPES

from omnimate.vcan_sim.nodes.abort import Abort, SdoAbort

if TYPE_CHECKING:
    from collections.abc import Mapping

EDS_FOLDER = Path(__file__).parent.parent / "eds"

Key = tuple[int, int]
Value = int | bytes


@dataclass(frozen=True, slots=True)
class Variable:
    """One entry of an object dictionary.

    Attributes:
        size: Size of an integer [byte]; None for a string.
        signed: Whether the integer is two's complement.
        writable: Whether SDO may write the object.
        mappable: Whether a PDO may carry the object.
        low: Lowest value allowed.
        high: Highest value allowed.
        default: Value after a reset.
        relative: Whether the node id is added to the default.
    """

    size: int | None
    signed: bool
    writable: bool
    mappable: bool
    low: int
    high: int
    default: Value
    relative: bool

    def encode(self, value: Value) -> bytes:
        """Return the bytes on the bus."""
        if isinstance(value, bytes):
            return value
        assert self.size is not None  # only strings have none, and their values are bytes
        return (value & ((1 << 8 * self.size) - 1)).to_bytes(self.size, "little")

    def decode(self, data: bytes) -> Value:
        """Return the value that SDO writes; raise SdoAbort if length or range is wrong."""
        if self.size is None:
            return bytes(data)
        if len(data) != self.size:
            raise SdoAbort(Abort.LENGTH)
        value = int.from_bytes(data, "little", signed=self.signed)
        if not self.low <= value <= self.high:
            raise SdoAbort(Abort.VALUE)
        return value


def _variable(entry: ODVariable) -> Variable:
    """Return the entry of an EDS file that `canopen` has read."""
    integer = entry.data_type in INTEGER_TYPES
    signed = entry.data_type in SIGNED_TYPES
    bits = len(entry)
    low, high = (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1) if signed else (0, 2**bits - 1)
    default = entry.default if entry.default is not None else 0
    return Variable(
        size=bits // 8 if integer else None,
        signed=signed,
        writable=bool(entry.writable),
        mappable=bool(entry.pdo_mappable),
        low=low if entry.min is None else int(entry.min),
        high=high if entry.max is None else int(entry.max),
        default=int(default) if integer else str(default).encode("ascii"),
        relative=bool(entry.relative),
    )


@lru_cache(maxsize=8)
def load_dictionary(eds: str) -> Mapping[Key, Variable]:
    """Return the entries of an EDS file of the simulated devices by (index, sub-index)."""
    entries = canopen.import_od(str(EDS_FOLDER / eds), node_id=0)
    variables: dict[Key, Variable] = {}
    for index, entry in entries.items():
        if isinstance(entry, ODVariable):
            variables[index, 0] = _variable(entry)
        else:
            variables.update({(index, sub): _variable(entry[sub]) for sub in entry.subindices})
    return MappingProxyType(variables)
