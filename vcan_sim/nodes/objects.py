"""The objects of a device: the entries of its EDS file, their values, checks and reactions (CiA 301 7.4)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

import canopen
from canopen.objectdictionary import ODVariable
from canopen.objectdictionary.datatypes import INTEGER_TYPES, SIGNED_TYPES

from omnimate.vcan_sim.errors import Abort, SdoAbort

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

EDS_FOLDER = Path(__file__).parent.parent / "eds"

Key = tuple[int, int]
Value = int | bytes


@dataclass(frozen=True, slots=True)
class Variable:
    """One entry of an object dictionary."""

    size: int | None  # size of an integer [byte]; None for a string
    signed: bool  # whether the integer is two's complement
    writable: bool  # whether SDO may write the object
    mappable: bool  # whether a PDO may carry the object
    low: int  # lowest value allowed
    high: int  # highest value allowed
    default: Value  # value after a reset
    relative: bool  # whether the node id is added to the default

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


def refuse_unless(is_valid: Callable[[int], bool], code: Abort = Abort.VALUE) -> Callable[[int, int], None]:
    """Return a check for `Objects.checks` that refuses a value with `code` unless it is valid."""

    def check(_sub: int, value: int) -> None:
        if not is_valid(value):
            raise SdoAbort(code)

    return check


# Objects that are commands, or a history: they are not stored by 1010h.
_NOT_STORED = {0x1003, 0x1010, 0x1011, 0x6003, 0x6010, 0x6040, 0x60FF}


class Objects:
    """The objects of one device: defaults of its EDS file, replaced by its settings and by written values."""

    def __init__(self, variables: Mapping[Key, Variable], node: int, settings: Mapping[Key, Value]) -> None:
        self.variables = variables  # entries of the object dictionary by (index, sub-index)
        self.node = node  # which some defaults contain; `assign` changes it
        # return the present values of objects that are measured or computed instead of stored
        self.readers: dict[Key, Callable[[], int]] = {}
        # called with (sub-index, value) before a value is stored; raise `SdoAbort` to refuse it
        self.checks: dict[int, Callable[[int, int], None]] = {}
        # called with (sub-index, value) after a value was stored
        self.reactions: dict[int, Callable[[int, int], None]] = {}
        self._defaults = {
            key: variable.default + node
            if variable.relative and isinstance(variable.default, int)
            else variable.default
            for key, variable in variables.items()
        }
        self._defaults.update(settings)
        self._stored: dict[Key, Value] = {}
        self._values = dict(self._defaults)

    def __contains__(self, key: Key) -> bool:
        return key in self.variables

    def __getitem__(self, key: Key) -> int:
        value = self._values[key]
        assert isinstance(value, int)  # only integers are asked for by the devices themselves
        return value

    def __setitem__(self, key: Key, value: Value) -> None:
        self._values[key] = value

    def variable(self, key: Key) -> Variable:
        """Return an entry; raise SdoAbort if there is none."""
        variable = self.variables.get(key)
        if variable is None:
            index_exists = (key[0], 0) in self.variables
            raise SdoAbort(Abort.NO_SUBINDEX if index_exists else Abort.NO_OBJECT)
        return variable

    def read(self, index: int, sub: int) -> bytes:
        """Return an object's bytes, as SDO uploads them; raises SdoAbort."""
        variable, reader = self.variable((index, sub)), self.readers.get((index, sub))
        return variable.encode(self._values[index, sub] if reader is None else reader())

    def size(self, index: int, sub: int) -> int | None:
        """Return the size of an object [byte], None for a string; raises SdoAbort."""
        return self.variable((index, sub)).size

    def write(self, index: int, sub: int, data: bytes) -> None:
        """Set an object, as SDO downloads and RPDOs do; raises SdoAbort if it is not there or refuses."""
        variable = self.variable((index, sub))
        if not variable.writable:
            raise SdoAbort(Abort.READ_ONLY)
        value = variable.decode(data)
        assert isinstance(value, int)  # no string of these devices can be written
        if index in self.checks:
            self.checks[index](sub, value)
        self[index, sub] = value
        if index in self.reactions:
            self.reactions[index](sub, value)

    def reader(self, key: Key) -> Callable[[], int]:
        """Return the function by which a PDO reads an object."""
        return self.readers.get(key) or (lambda: self[key])

    def reset(self, last_index: int) -> None:
        """Set all objects up to an index, included, to their values after power-on."""
        values = self._defaults | self._stored
        self._values.update({key: value for key, value in values.items() if key[0] <= last_index})

    def store(self) -> None:
        """Store the objects that SDO may write, for the next power-on (1010h)."""
        self._stored = {
            key: self._values[key]
            for key, variable in self.variables.items()
            if variable.writable and key[0] not in _NOT_STORED
        }

    def forget_stored(self) -> None:
        """Discard the stored values, so that the defaults are restored at the next power-on (1011h)."""
        self._stored = {}

    def assign(self, node: int) -> None:
        """Change the node id in all defaults that contain it, and discard the stored values of these."""
        for key, variable in self.variables.items():
            default = self._defaults[key]
            if variable.relative and isinstance(default, int):
                self._defaults[key] = default + node - self.node
                self._stored.pop(key, None)
        self.node = node
