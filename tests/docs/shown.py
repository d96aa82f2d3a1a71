"""Compare what a command printed with what a page shows.

Words must be the same. Numbers may differ by 2 %, or by two units of their last decimal, because
processors round differently. `...` stands for any text in a line; alone on a line, for any number of lines.
"""

from __future__ import annotations

import re
from functools import cache

NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
CONTROL = re.compile(r"\x1b\[[0-9;?]*[A-Za-z]")


def plain(text: str) -> list[str]:
    """Return the lines of an output without control sequences, trailing spaces and empty lines around it."""
    lines = [
        CONTROL.sub("", line).split("\r")[-1].rstrip() for line in text.replace("\r\n", "\n").split("\n")
    ]
    while lines and not lines[0]:
        lines = lines[1:]
    while lines and not lines[-1]:
        lines = lines[:-1]
    return lines


def same(shown: tuple[str, ...], printed: tuple[str, ...]) -> bool:
    """Return whether the printed lines are those that are shown."""

    @cache
    def rest(left: int, right: int) -> bool:
        if left == len(shown):
            return right == len(printed)
        if shown[left].strip() == "...":
            return rest(left + 1, right) or (right < len(printed) and rest(left, right + 1))
        return right < len(printed) and line_is(shown[left], printed[right]) and rest(left + 1, right + 1)

    return rest(0, 0)


def line_is(shown: str, printed: str) -> bool:
    """Return whether one printed line is the one that is shown."""
    pieces = [NUMBER.findall(part) for part in shown.split("...")]
    pattern = ".*?".join(_pattern(part) for part in shown.split("..."))
    match = re.fullmatch(pattern, printed.strip())
    if match is None:
        return False
    numbers = [number for piece in pieces for number in piece]
    return all(_near(left, right) for left, right in zip(numbers, match.groups(), strict=True))


def _pattern(part: str) -> str:
    """Return the expression for a part of a line: any numbers, and any widths of spaces and rules."""
    texts = [re.escape(text) for text in NUMBER.split(part.strip())]
    pattern = f"({NUMBER.pattern})".join(texts)
    return r"\s*" + re.sub(r"(?:\\ )+", r"\\s+", re.sub(r"(?:─|━)+", "[─━]+", pattern)) + r"\s*"


def _near(shown: str, printed: str) -> bool:
    mantissa, _, exponent = shown.partition("e")
    digits = len(mantissa.partition(".")[2])
    units = 2.0 * 10.0 ** (int(exponent or 0) - digits) if digits else 0.0
    return abs(float(shown) - float(printed)) <= max(units, 0.02 * abs(float(shown)))
