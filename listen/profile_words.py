"""Code lengths of the status word and the control word of a drive, by the bits of CiA 402."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from omnimate.listen.priors import Kind

# Mask and value of each state: CiA 402-2 (IEC 61800-7-201), table of the states of the status word. Up to
# operation enabled, each one is followed by the next when a drive is switched on (transitions 1 to 4).
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
# Mask and value of each command of the control word, from the same standard, in the order in which a drive
# is switched on.
COMMANDS: dict[str, tuple[int, int]] = {
    "disable voltage": (0x82, 0x00),
    "shutdown": (0x87, 0x06),
    "switch on": (0x8F, 0x07),
    "enable operation": (0x8F, 0x0F),
    "quick stop": (0x86, 0x02),
    "fault reset": (0x80, 0x80),
}
# Objects of CiA 402, 406 and 401 that are mapped into PDOs: width, kind and sign. Those of CiA 406 and 401
# that have an index of CiA 402, too, are arrays: their sub-index is not 0.
_VARIABLES: dict[tuple[int, ...], tuple[int, Kind, bool | None]] = {
    (0x6040,): (16, "control word", None),
    (0x6041,): (16, "status word", None),
    (0x603F, 0x6500, 0x6503, 0x6505): (16, "bits", None),
    (0x6060, 0x6061): (8, "bits", None),
    (0x60FD,): (32, "bits", None),
    (0x6004,): (32, "number", False),
    (0x6062, 0x6063, 0x6064, 0x6069, 0x606B, 0x606C, 0x607A, 0x60F4, 0x60FA, 0x60FC, 0x60FF): (
        32,
        "number",
        True,
    ),
    (0x6042, 0x6043, 0x6044, 0x6071, 0x6074, 0x6077, 0x6078): (16, "number", True),
}
_ARRAYS: dict[tuple[int, ...], tuple[int, Kind, bool | None]] = {
    (0x60FE,): (32, "bits", None),
    (0x6000, 0x6200, 0x6300): (8, "bits", None),
    (0x6020, 0x60C1): (32, "number", True),
    (0x6030, 0x6040, 0x6401, 0x6411): (16, "number", True),
}
_STATUS_SET = 0x0210  # remote, and voltage enabled
_STATUS_EVEN = 0x3400  # target reached, and two bits of the mode of operation
_CONTROL_EVEN = 0x0010  # bit 4 starts a movement in the modes that have one
USUAL_BIT_SHARE = 0.9  # share of words in which a free bit has its normal value (assumption)


def profile_reading(name: str, bits: int) -> tuple[Kind, bool | None] | None:
    """Return the kind and sign that a profile gives a mapped object of this width; None where none does.

    Args:
        name: Name of the signal, such as `5.6020h:01 Position 1`; empty where the object is not known.
        bits: Its width.
    """
    place = name.partition(".")[2].partition(" ")[0]
    index, _, subindex = place.partition("h")
    objects = _ARRAYS if subindex else _VARIABLES
    for indices, (width, kind, signed) in objects.items():
        if index and int(index, 16) in indices and bits == width:
            return kind, signed
    return None


def status_bits(values: NDArray[np.uint64]) -> float:
    """Return the bits of the distinct values of a status word in their order; infinite where it is none.

    The first one is described whole, each other one by its state and by the other bits that have changed.
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
        meanings: Mask and value of each meaning, in the order in which they come.
        working: The meaning with which a drive turns its wheel.
        usual: Free bits that are set in most words; the others are not.
        even: Free bits that are as often set as not.
    """
    names = list(meanings)
    total, before, expected = 0.0, -1, {working, *names[:2]}  # a log begins while it works, or is switched on
    for value in values.tolist():
        matching = [name for name, (mask, wanted) in meanings.items() if value & mask == wanted]
        if not matching:
            return math.inf
        name = max(matching, key=lambda name: meanings[name][0].bit_count())
        free = ~meanings[name][0] & 0xFFFF
        rest = len(meanings) - len(expected)
        total += (
            _bits_of(True) + math.log2(len(expected))
            if name in expected
            else _bits_of(False) + math.log2(rest)
        )
        expected = {name, working if name == working else names[(names.index(name) + 1) % len(names)]}
        odd = value ^ (usual if before < 0 else before)
        certain = free & ~even if before < 0 else free
        flips = (odd & certain).bit_count()
        total += flips * _bits_of(False) + (certain.bit_count() - flips) * _bits_of(True)
        total += 0 if before >= 0 else (free & even).bit_count()
        before = value
    return total


def _bits_of(usual: bool) -> float:
    return -math.log2(USUAL_BIT_SHARE if usual else 1.0 - USUAL_BIT_SHARE)
