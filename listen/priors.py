"""Prior probabilities of kinds and widths of the objects in a PDO.

The widths of numbers are those of the objects of CiA 402 (6062h to 6064h, 6069h, 606Bh, 606Ch, 6079h, 607Ah,
60C1h, 60F4h, 60FDh, 60FFh with 32 bits; 6042h to 6044h, 6071h, 6074h, 6077h, 6078h with 16), CiA 406 (6004h,
6020h, 6050h with 32; 6030h, 6040h with 16) and CiA 401 (6401h, 6411h with 16; 6400h, 6410h with 8), counted;
those of states are of 6041h, 6040h, 603Fh, 6500h, 6503h, 6505h (16), 6060h, 6061h, 1001h, 6000h, 6200h,
6300h, 6400h (8), 1002h, 60FDh, 60FEh (32). A fifth of the numbers is taken for vendors' objects (2000h to
5FFFh), of which no profile says anything: 8, 16 and 32 bits are alike to them. Another width gets
`RARE_WIDTH`.
"""

from __future__ import annotations

from typing import Literal

Kind = Literal["constant", "status word", "control word", "bits", "number", "float"]

Direction = Literal["sent", "received", "unknown"]  # by a device, as the predefined connections say

RARE_WIDTH = 2.0**-12  # prior of another width: none of the 37 objects above, few of thousands of vendors'
# The share of each kind: of the objects above, with a fifth of what is mapped unchanged in a log. CiA 402's
# default PDOs begin with the status word or control word; no device sends commands or receives states.
KINDS: dict[Direction, dict[Kind, float]] = {
    "sent": {
        "number": 0.46,
        "bits": 0.20,
        "constant": 0.20,
        "status word": 0.10,
        "control word": 0.002,
        "float": 0.038,
    },
    "received": {
        "number": 0.46,
        "bits": 0.16,
        "constant": 0.20,
        "status word": 0.002,
        "control word": 0.15,
        "float": 0.028,
    },
    "unknown": {
        "number": 0.48,
        "bits": 0.26,
        "constant": 0.20,
        "status word": 0.005,
        "control word": 0.005,
        "float": 0.05,
    },
}
WIDTHS: dict[Kind, dict[int, float]] = {
    "number": {32: 0.53, 16: 0.36, 8: 0.10},
    "bits": {16: 0.38, 8: 0.45, 32: 0.16},
    "constant": {16: 0.38, 8: 0.40, 32: 0.21},
    "status word": {16: 1.0},
    "control word": {16: 1.0},
    "float": {32: 1.0},
}
ZERO_SHARE = 0.7  # share of the values that never change which are zero: no error, no warning, unused
BIG_ENDIAN = 0.02  # CiA 301 section 7.1.4 requires little-endian; assumption: 2 % violate it
BIG_ENDIAN_ELSEWHERE = 0.5  # without CANopen both orders are equally likely
# Of the messages of a CANopen node: one whose maker packs bits as in a car has widths of all kinds.
PACKED = 0.01
PACKED_ELSEWHERE = 0.5


def width_share(kind: Kind, bits: int) -> float:
    """Return the share of a width among the fields of a kind; 0 where there can be none."""
    known = WIDTHS[kind]
    if len(known) == 1:
        return known.get(bits, 0.0)
    return known.get(bits, RARE_WIDTH)


def packed_share(kind: Kind, bits: int) -> float:
    """Return the share of a width where no profile holds: all are alike, from a bit to half of a message."""
    known = WIDTHS[kind]
    return known.get(bits, 0.0) if len(known) == 1 else 1.0 / 32.0


# Steps of a number of floating point are of 2^6 units of the last place and more; finer is one of 256.
FLOAT_STEP, FLOAT_STEP_BITS = 64, 8.0
