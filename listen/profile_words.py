"""Code lengths of the status word and the control word of a drive, by the bits of CiA 402."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from omnimate.listen.priors import Kind

# Mask and value of each state in the status word: CiA 402-2 (IEC 61800-7-201). A drive that is switched on
# passes the states in this order up to operation enabled (transitions 1 to 4).
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
# Objects of CiA 402, 406 and 401 that are mapped into PDOs: width [bits], kind, and whether they are signed.
# An index that CiA 402 shares with CiA 406 or 401 is a variable in the former, and an array in the latter.
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
_STATUS_DEFAULT = 0x0210  # bits that are mostly set: remote, and voltage enabled
# Bits that are 0 and 1 equally often: target reached, and two of the mode of operation
_STATUS_EQUAL = 0x3400
_CONTROL_EQUAL = 0x0010  # bit 4 starts a movement in some modes
# Share of words with the expected state, and of free bits with their default (assumption)
DEFAULT_SHARE = 0.9


def profile_reading(name: str, bits: int) -> tuple[Kind, bool | None] | None:
    """Return the kind of a mapped object by its profile, and whether it is signed; None if no profile has it.

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
    """Return the code length of distinct values in their order, `(K,)`, as a status word [bits].

    It is infinite if a value has no state of CiA 402. The first value is coded by its state and all other
    bits, each further one by its state and the other bits that have changed.
    """
    return _word_bits(values, STATES, "operation enabled", _STATUS_DEFAULT, _STATUS_EQUAL)


def control_bits(values: NDArray[np.uint64]) -> float:
    """Return the code length of distinct values in their order, `(K,)`, as a control word [bits].

    It is infinite if a value has no command of CiA 402.
    """
    return _word_bits(values, COMMANDS, "enable operation", 0, _CONTROL_EQUAL)


def _word_bits(
    values: NDArray[np.uint64], meanings: dict[str, tuple[int, int]], enabled: str, default: int, equal: int
) -> float:
    """Return the code length of the values of a word [bits].

    Args:
        values: Distinct values in the order in which they came.
        meanings: Mask and value of each state or command, in the order in which a drive is switched on.
        enabled: The state or command with which a drive moves.
        default: Bits outside the mask that are mostly set; the others are mostly not set.
        equal: Bits outside the mask that are 0 and 1 equally often.
    """
    names = list(meanings)
    # A log begins while the drive moves, or while it is switched on.
    total, before, expected = 0.0, -1, {enabled, *names[:2]}
    for value in values.tolist():
        matching = [name for name, (mask, pattern) in meanings.items() if value & mask == pattern]
        if not matching:
            return math.inf
        name = max(matching, key=lambda name: meanings[name][0].bit_count())
        free = ~meanings[name][0] & 0xFFFF
        choices = len(expected) if name in expected else len(meanings) - len(expected)
        total += _bits_of(name in expected) + math.log2(choices)
        expected = {name, enabled if name == enabled else names[(names.index(name) + 1) % len(names)]}
        predicted = default if before < 0 else before
        coded = free & ~equal if before < 0 else free
        flips = ((value ^ predicted) & coded).bit_count()
        total += flips * _bits_of(False) + (coded.bit_count() - flips) * _bits_of(True)
        total += 0 if before >= 0 else (free & equal).bit_count()
        before = value
    return total


def _bits_of(is_as_predicted: bool) -> float:
    return -math.log2(DEFAULT_SHARE if is_as_predicted else 1.0 - DEFAULT_SHARE)
