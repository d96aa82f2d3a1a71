"""Prior probabilities of kinds and widths of the objects in a PDO.

The shares are counts of objects that can be mapped. Numbers are those of CiA 402 (6062h to 6064h, 6069h,
606Bh, 606Ch, 6079h, 607Ah, 60C1h, 60F4h, 60FDh, 60FFh with 32 bits; 6042h to 6044h, 6071h, 6074h, 6077h,
6078h with 16), CiA 406 (6004h, 6020h, 6050h with 32; 6030h, 6040h with 16) and CiA 401 (6401h, 6411h with 16;
6400h, 6410h with 8). States and flags are 6041h, 6040h, 603Fh, 6500h, 6503h, 6505h (16), 6060h, 6061h, 1001h,
6000h, 6200h, 6300h, 6400h (8), 1002h, 60FDh, 60FEh (32). A fifth of the numbers is assumed to be vendors'
objects (2000h to 5FFFh), in which 8, 16 and 32 bits are equally likely. Any other width has the prior
`RARE_WIDTH`.
"""

from __future__ import annotations

from typing import Literal

Kind = Literal["constant", "status word", "control word", "bits", "number", "float"]

Direction = Literal["sent", "received", "unknown"]  # by a node, from the predefined connections of CiA 301

# Prior of a width that is not in `WIDTHS`: none of the 37 objects above has one, few of thousands of vendors'
# do.
RARE_WIDTH = 2.0**-12
# Share of each kind among the objects above; a fifth of the mapped objects is assumed to be constant in a
# log. The default PDOs of CiA 402 begin with the status word (sent) or the control word (received).
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
ZERO_SHARE = 0.7  # share of zeros among constant values: no error, no warning, unused (assumption)
BIG_ENDIAN = 0.02  # CiA 301 section 7.1.4 requires little-endian; assumption: 2 % of messages violate it
BIG_ENDIAN_ELSEWHERE = 0.5  # without CANopen both orders are equally likely
PACKED = 0.01  # share of CANopen messages whose fields have any width in bits, as in a car (assumption)
PACKED_ELSEWHERE = 0.5  # the same share among messages of other senders (assumption)
# Steps of a floating-point number are at least 64 units in the last place; prior of smaller steps: 1 in 256.
FLOAT_STEP, FLOAT_STEP_BITS = 64, 8.0  # [units in the last place], [bits]; assumptions


def width_share(kind: Kind, bits: int) -> float:
    """Return the prior of a width among the fields of a kind; 0 if the kind has only one, other width."""
    known = WIDTHS[kind]
    if len(known) == 1:
        return known.get(bits, 0.0)
    return known.get(bits, RARE_WIDTH)


def packed_share(kind: Kind, bits: int) -> float:
    """Return the prior of a width in packed messages: 1 to 32 bits are equally likely.

    Status words, control words and floats have one width only, as in `width_share`.
    """
    known = WIDTHS[kind]
    return known.get(bits, 0.0) if len(known) == 1 else 1.0 / 32.0
