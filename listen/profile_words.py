"""The status word and the control word of a drive, recognised by what CiA 402 says of their bits."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

# Mask and value of each state: CiA 402-2 (IEC 61800-7-201), table of the states of the status word.
STATES: dict[str, tuple[int, int]] = {
    "not ready to switch on": (0x4F, 0x00),
    "switch on disabled": (0x4F, 0x40),
    "ready to switch on": (0x6F, 0x21),
    "switched on": (0x6F, 0x23),
    "operation enabled": (0x6F, 0x27),
    "quick stop active": (0x6F, 0x07),
    "fault reaction active": (0x4F, 0x0F),
    "fault": (0x4F, 0x08),
}
# Mask and value of each command of the control word, from the same standard.
COMMANDS: dict[str, tuple[int, int]] = {
    "shutdown": (0x87, 0x06),
    "switch on": (0x8F, 0x07),
    "enable operation": (0x8F, 0x0F),
    "disable voltage": (0x82, 0x00),
    "quick stop": (0x86, 0x02),
    "fault reset": (0x80, 0x80),
}
_STATUS_SET = 0x0210  # remote, and voltage enabled
_STATUS_EVEN = 0x3400  # target reached, and two bits of the mode of operation
_CONTROL_EVEN = 0x0010  # bit 4 starts a movement in the modes that have one
USUAL = 0.9  # share of the words of a drive that works in which a bit is as it is when all is well


def status_bits(values: NDArray[np.uint64]) -> float:
    """Return the bits of the distinct values of a status word in their order; infinite where it is none.

    The first one is told whole, each other one by its state and by the other bits that have changed.
    """
    return _word_bits(values, STATES, "operation enabled", _STATUS_SET, _STATUS_EVEN)


def control_bits(values: NDArray[np.uint64]) -> float:
    """Return the bits of the distinct values of a control word in their order; infinite where it is none."""
    return _word_bits(values, COMMANDS, "enable operation", 0, _CONTROL_EVEN)


def _word_bits(
    values: NDArray[np.uint64], meanings: dict[str, tuple[int, int]], working: str, usual: int, even: int
) -> float:
    """Return the bits of the values of a word.

    Args:
        values: Distinct values in the order in which they came.
        meanings: Mask and value of each meaning.
        working: The meaning with which a drive turns its wheel.
        usual: Free bits that are set in most words; the others are not.
        even: Free bits that are as often set as not.
    """
    total, before = 0.0, -1
    for value in values.tolist():
        found = [name for name, (mask, wanted) in meanings.items() if value & mask == wanted]
        if not found:
            return math.inf
        name = max(found, key=lambda name: meanings[name][0].bit_count())
        free = ~meanings[name][0] & 0xFFFF
        total += _bits_of(True) if name == working else _bits_of(False) + math.log2(len(meanings) - 1)
        odd = value ^ (usual if before < 0 else before)
        certain = free & ~even if before < 0 else free
        flips = (odd & certain).bit_count()
        total += flips * _bits_of(False) + (certain.bit_count() - flips) * _bits_of(True)
        total += 0 if before >= 0 else (free & even).bit_count()
        before = value
    return total


def _bits_of(usual: bool) -> float:
    return -math.log2(USUAL if usual else 1.0 - USUAL)
