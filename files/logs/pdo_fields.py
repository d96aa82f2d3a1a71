"""Fields of a PDO: little-endian bits as CiA 301 packs them, for whole columns of frames."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from omnimate.vehicle.parameters import Encoder


def decode(words: NDArray[np.uint64], encoder: Encoder) -> NDArray[np.int64]:
    """Return the raw counts in PDOs given as little-endian numbers, `(N,)`; 64 unsigned bits modulo 2^64."""
    left = np.uint64(64 - encoder.start_bit - encoder.bits)
    right = np.uint64(64 - encoder.bits)
    shifted = words << left  # the field's highest bit is the number's: the shift back extends its sign
    return (
        shifted.view(np.int64) >> right.view(np.int64)
        if encoder.signed
        else (shifted >> right).view(np.int64)
    )


def encode(counts: NDArray[np.int64], encoder: Encoder) -> NDArray[np.uint64]:
    """Return the bits of PDOs, `(N,)`, whose field shows the counts as the wrapping counter would."""
    raw = counts % encoder.wrap_range if encoder.wrap_range < 2**63 else counts
    if encoder.signed and encoder.wrap_range < 2**encoder.bits:
        raw = raw - encoder.wrap_range * (raw >= (encoder.wrap_range + 1) // 2)
    mask = np.uint64(2**encoder.bits - 1)
    return (raw.astype(np.int64).view(np.uint64) & mask) << np.uint64(encoder.start_bit)
