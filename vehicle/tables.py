"""Conversion of TOML tables to dataclasses with strict checks; errors name the key."""

from __future__ import annotations

import tomllib
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any, TypeVar

from omnimate.vehicle.errors import TableError, describe_read_error

T = TypeVar("T")

# The annotations that a field may have, the Python types of its values in TOML, and their description.
_SCALARS: dict[str, tuple[tuple[type, ...], str]] = {
    "float": ((int, float), "a number"),
    "int": ((int,), "a whole number"),
    "bool": ((bool,), "true or false"),
    "str": ((str,), "text"),
    "Channel": ((str,), "text"),
    "Profile": ((str,), "text"),
}
_LISTS = {
    "tuple[float, ...]": ("float", None, "a list of numbers"),
    "tuple[float, float]": ("float", 2, "a [start, end] pair"),
    "tuple[tuple[float, float], ...]": ("tuple[float, float]", None, "a list of [start, end] pairs"),
}
_MAX_INTEGER_BITS = 1023  # bits of a whole number that a float can still hold


def read_toml(path: Path | str) -> dict[str, Any]:
    """Return the document in a TOML file.

    Raises:
        TableError: It cannot be read, or is not TOML.
    """
    try:
        text = Path(path).read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise TableError("(file)", f"cannot be read: {describe_read_error(error)}") from error
    return parse_toml(text)


def parse_toml(text: str) -> dict[str, Any]:
    """Return the document that a text holds.

    Raises:
        TableError: It is not TOML.
    """
    try:
        document = tomllib.loads(text)
        repr(document)  # fails for whole numbers that no message can print (hexadecimal ones are read)
    except (ValueError, RecursionError) as error:
        raise TableError("(syntax)", f"not TOML: {error}") from error
    return document


def dataclass_of(kind: type[T], table: object, where: str) -> T:
    """Return a dataclass, whose fields are numbers, texts, booleans or lists of numbers, from a TOML table.

    `where` is the key of the table in its document, such as `truck.a`.

    Raises:
        TableError: It is not a table, a key is unknown or missing, a value has another type, or the dataclass
            refuses a value by a `TableError` of its own; the error names the key with `where` in front.
    """
    if not isinstance(table, dict):
        raise TableError(where, f"{table!r}; expected a table")
    known = {field.name: field for field in fields(kind)}  # type: ignore[arg-type]  # a dataclass
    for key in table:
        if key not in known:
            raise TableError(f"{where}.{key}", f"unknown key; expected one of {', '.join(known)}")
    values = {}
    for key, field in known.items():
        if key in table:
            values[key] = value_of(str(field.type), table[key], f"{where}.{key}")
        elif field.default is MISSING:
            raise TableError(f"{where}.{key}", f"missing; expected {_words(str(field.type))}")
    try:
        return kind(**values)
    except TableError as error:
        raise TableError(f"{where}.{error.key}", error.problem) from error


def value_of(annotation: str, value: Any, where: str) -> Any:  # noqa: ANN401  # from TOML
    """Return a value that fits a field's annotation, lists as tuples.

    Raises:
        TableError: It has another type; the error names `where`.
    """
    if not _fits(annotation.removesuffix(" | None"), value):
        raise TableError(where, f"{value!r}; expected {_words(annotation)}")
    return _frozen(value)


def _words(annotation: str) -> str:
    annotation = annotation.removesuffix(" | None")
    return (_SCALARS.get(annotation) or _LISTS[annotation])[-1]


def _fits(annotation: str, value: Any) -> bool:  # noqa: ANN401
    if annotation in _LISTS:
        inner, length, _ = _LISTS[annotation]
        fits = isinstance(value, list) and (length is None or len(value) == length)
        return fits and all(_fits(inner, item) for item in value)
    types, _ = _SCALARS[annotation]
    too_large = annotation == "float" and isinstance(value, int) and value.bit_length() > _MAX_INTEGER_BITS
    return isinstance(value, types) and (not isinstance(value, bool) or bool in types) and not too_large


def _frozen(value: Any) -> Any:  # noqa: ANN401
    return tuple(_frozen(item) for item in value) if isinstance(value, list) else value
