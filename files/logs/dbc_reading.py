"""DBC files of any tool, as signals by identifier."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import TYPE_CHECKING

from omnimate.files.logs.signals import Signal
from omnimate.vehicle.errors import LogError

if TYPE_CHECKING:
    from pathlib import Path

EXTENDED_KEY = 1 << 31  # in a DBC file and in the keys below: a 29-bit identifier
_MESSAGE = re.compile(r"BO_\s+(\d+)\s+(\w+)\s*:")
_SIGNAL = re.compile(
    r"\s*SG_\s+(\w+)\s*(M|m\d+M?)?\s*:\s*(\d+)\|(\d+)@([01])([+-])\s*"
    r"\(\s*([^,\s]+)\s*,\s*([^)\s]+)\s*\)\s*\[[^\]]*\]\s*\"([^\"]*)\""
)
_FLOAT = re.compile(r"SIG_VALTYPE_\s+(\d+)\s+(\w+)\s*:\s*([12])")
_CHOICES = re.compile(r"VAL_\s+(\d+)\s+(\w+)\s+(.*?);", re.DOTALL)
_CHOICE = re.compile(r"(-?\d+)\s+\"([^\"]*)\"")


def read_dbc(path: Path) -> dict[int, tuple[Signal, ...]]:
    """Return the signals of a DBC file by identifier, to which `EXTENDED_KEY` is added for 29 bits.

    Raises:
        LogError: The file cannot be read, or holds no message.
    """
    try:
        text = path.read_bytes().decode("cp1252", "replace")
    except OSError as error:
        raise LogError(path, None, f"cannot be read: {error.strerror or error}") from error
    messages = _messages(path, text)
    if not messages:
        raise LogError(path, 1, "no message in the file; expected lines such as `BO_ 385 name: 8 node`")
    for match in _FLOAT.finditer(text):
        _change(messages, match, is_float=True)
    for match in _CHOICES.finditer(text):
        choices = {int(value): words for value, words in _CHOICE.findall(match[3])}
        _change(messages, match, choices=choices)
    return {key: tuple(signals.values()) for key, signals in messages.items() if signals}


def _messages(path: Path, text: str) -> dict[int, dict[str, Signal]]:
    """Return the signals of each message by name, each with its multiplexor if it has one."""
    messages: dict[int, dict[str, Signal]] = {}
    switches: dict[int, Signal] = {}
    switched: list[tuple[int, str, int]] = []
    key = -1
    for number, line in enumerate(text.splitlines(), start=1):
        if match := _MESSAGE.match(line):
            key = int(match[1])
            messages.setdefault(key, {})
        elif key >= 0 and (match := _SIGNAL.match(line)):
            messages[key][match[1]] = _signal(path, number, match)
            if match[2] == "M":
                switches[key] = messages[key][match[1]]
            elif match[2]:
                switched.append((key, match[1], int(match[2].strip("mM"))))
    for key, name, value in switched:
        if key in switches:
            messages[key][name] = replace(messages[key][name], switch=(switches[key], value))
    return messages


def _signal(path: Path, line: int, match: re.Match[str]) -> Signal:
    start, bits = int(match[3]), int(match[4])
    try:
        factor, offset = float(match[7]), float(match[8])
    except ValueError as error:
        raise LogError(path, line, f"factor or offset of {match[1]} is no number") from error
    signal = Signal(
        match[1], start, bits, match[6] == "-", factor, offset, match[9], is_big_endian=match[5] == "0"
    )
    if not 1 <= bits <= 64 or signal.shift < 0 or signal.length > 8:
        raise LogError(path, line, f"{match[1]} with {bits} bits from bit {start} does not fit 8 bytes")
    return signal


def _change(messages: dict[int, dict[str, Signal]], match: re.Match[str], **changes: object) -> None:
    signals = messages.get(int(match[1]), {})
    if match[2] in signals:
        signals[match[2]] = replace(signals[match[2]], **changes)  # type: ignore[arg-type]  # fields of Signal
