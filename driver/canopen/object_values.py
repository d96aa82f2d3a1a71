"""Values of objects as people write them: numbers, text and bytes, by the data types of CiA 301."""

from __future__ import annotations

import re
import struct
from typing import TYPE_CHECKING

from canopen.objectdictionary import ODVariable
from canopen.objectdictionary import datatypes as types

from omnimate.driver.errors import DriverError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from canopen.objectdictionary import ObjectDictionary

_WIDTHS = (8, 16, 24, 32, 40, 48, 56, 64)  # [bit] of the integers of CiA 301
FLOATS = {"f32": "<f", "f64": "<d"}
_KIND_OF = {
    **{getattr(types, f"UNSIGNED{bits}"): f"u{bits}" for bits in _WIDTHS},
    **{getattr(types, f"INTEGER{bits}"): f"i{bits}" for bits in _WIDTHS},
    types.BOOLEAN: "u8",
    types.REAL32: "f32",
    types.REAL64: "f64",
    types.VISIBLE_STRING: "text",
    **dict.fromkeys((types.OCTET_STRING, types.UNICODE_STRING, types.DOMAIN), "hex"),
}
INTEGERS = {f"{sign}{bits}" for sign in "ui" for bits in _WIDTHS}
KINDS = (*sorted(INTEGERS), *FLOATS, "text", "hex")
_PLACE = re.compile(r"(?:0x)?([0-9A-Fa-f]{4})h?(?::(?:0x)?([0-9A-Fa-f]{1,2})h?)?")


class ValueTextError(DriverError):
    """A value or an object that cannot be understood."""


def place_of(text: str, dictionary: ObjectDictionary) -> tuple[int, int]:
    """Return index and sub-index of `6004`, `6004h`, `0x1018:4`, `1018h:04`, or of an object's name.

    Raises ValueTextError where it is neither, or no object has this name.
    """
    if match := _PLACE.fullmatch(text.strip()):
        return int(match[1], 16), int(match[2] or "0", 16)
    for variable in variables_of(dictionary):
        if text.lower() in {str(variable.qualname).lower(), str(variable.name).lower()}:
            return variable.index, variable.subindex
    raise ValueTextError(f"object {text!r}: expected 6004h, 1018h:04, or the name of an object in the EDS")


def variables_of(dictionary: ObjectDictionary) -> Iterator[ODVariable]:
    """Yield every variable of an object dictionary, in the order of index and sub-index."""
    for _, entry in sorted(dictionary.items()):
        if isinstance(entry, ODVariable):
            yield entry
        else:
            for _, variable in sorted(entry.subindices.items()):
                yield variable


def default_of(dictionary: ObjectDictionary, index: int, subindex: int) -> int | None:
    """Return the value that an EDS or DCF states for a number, None where it states none."""
    variable = dictionary.get_variable(index, subindex)
    if variable is None:
        return None
    value = variable.default if variable.value is None else variable.value
    return value if isinstance(value, int) else None


def kind_of(dictionary: ObjectDictionary, index: int, subindex: int) -> str | None:
    """Return the kind in `KINDS` that a dictionary gives an object; None where it knows none."""
    variable = dictionary.get_variable(index, subindex)
    return None if variable is None else _KIND_OF.get(variable.data_type or 0)


def decode(data: bytes, kind: str | None) -> int | float | str:
    """Return the value of an object's bytes; without a kind, a number of up to 4 bytes, else hexadecimal."""
    if kind is None:
        return int.from_bytes(data, "little") if len(data) <= 4 else data.hex(" ").upper()
    if kind in FLOATS and len(data) == struct.calcsize(FLOATS[kind]):
        return float(struct.unpack(FLOATS[kind], data)[0])
    if kind in INTEGERS:
        return int.from_bytes(data, "little", signed=kind[0] == "i")
    if kind == "text":
        return data.split(b"\0")[0].decode("utf-8", "replace")
    return data.hex(" ").upper()


def encode(text: str, kind: str) -> bytes:
    """Return the bytes of a value that is written as `kind`; integers may be `0x1F` or `1Fh`.

    Raises ValueTextError where the text is no such value, or does not fit.
    """
    try:
        if kind in FLOATS:
            return struct.pack(FLOATS[kind], float(text))
        if kind == "text":
            return text.encode()
        if kind == "hex":
            return bytes.fromhex(text)
        number = int(text[:-1], 16) if text[-1:] in {"h", "H"} else int(text, 0)
        return number.to_bytes(int(kind[1:]) // 8, "little", signed=kind[0] == "i")
    except (ValueError, OverflowError, struct.error) as error:
        raise ValueTextError(f"value {text!r} is no {kind}; expected {_expected(kind)}") from error


def _expected(kind: str) -> str:
    """Return what a value of a kind looks like."""
    if kind in FLOATS:
        return "a number, such as 1.5"
    if kind == "hex":
        return "bytes of two hexadecimal digits, such as '01 0A FF'"
    bits = int(kind[1:])
    low, high = (-(1 << bits - 1), (1 << bits - 1) - 1) if kind[0] == "i" else (0, (1 << bits) - 1)
    return f"a whole number from {low} to {high}, such as 31, 0x1F or 1Fh"
