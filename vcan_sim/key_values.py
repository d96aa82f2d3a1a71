"""Lists of `key=value`, as the command line writes faults and bumps: `node=2,at=30`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

Problem = Callable[[str], Exception]


class Kind(NamedTuple):
    """How a value is read.

    Attributes:
        read: Function from the text to the value; raises `ValueError` where it cannot be read.
        expected: What the text should be, for the error message.
    """

    read: Callable[[str], object]
    expected: str


NUMBER = Kind(float, "a number")
INTEGER = Kind(lambda text: int(text, 0), "an integer")
TEXT = Kind(str, "a text")
BYTES = Kind(lambda text: bytes.fromhex(text)[:8].hex(), "hexadecimal digits")


def read_values(text: str, kinds: Mapping[str, Kind], problem: Problem) -> dict[str, object]:
    """Return the values of a list by their keys.

    Args:
        text: Pairs of `key=value` with commas between them; empty for no values.
        kinds: Kind of the value of every key that may be given.
        problem: Function from the description of a problem to the error that is raised for it.
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
