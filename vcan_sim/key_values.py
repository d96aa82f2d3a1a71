"""Lists of `key=value`, as the command line writes faults and bumps: `node=2,at=30`."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

Problem = Callable[[str], Exception]


class Kind(NamedTuple):
    """A type of values and its parser."""

    # function from the text to the value; raises `ValueError` if the text is invalid
    read: Callable[[str], object]
    expected: str  # what the text should be, for the error message


def _number(text: str) -> float:
    value = float(text)
    if math.isnan(value):
        raise ValueError(text)
    return value


NUMBER = Kind(_number, "a number")
INTEGER = Kind(lambda text: int(text, 0), "an integer")
TEXT = Kind(str, "a text")
BYTES = Kind(lambda text: bytes.fromhex(text)[:8].hex(), "hexadecimal digits")


def read_values(text: str, kinds: Mapping[str, Kind], problem: Problem) -> dict[str, object]:
    """Return the values of a list by their keys, of which `kinds` are allowed.

    Raises the result of `problem`, made from a description, for an unknown key or an invalid value.
    """
    values: dict[str, object] = {}
    for pair in filter(None, text.split(",")):
        key, equals, value = pair.partition("=")
        if key not in kinds or not equals:
            raise problem(f"{pair!r} cannot be read; expected key=value with {', '.join(kinds)}")
        kind = kinds[key]
        try:
            values[key] = kind.read(value)
        except ValueError:
            raise problem(f"{pair}: expected {kind.expected}") from None
    return values
