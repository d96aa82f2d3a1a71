"""Code lengths of a column of raw values under models of its content: minimum description length.

The shorter description is the more probable one: a code of length L has probability 2^-L (Rissanen,
"Modeling by shortest data description", Automatica 14, 1978). No code has tuned parameters: parameters
learned from the column are part of its code length.
"""

from __future__ import annotations

import math
from functools import cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Column = NDArray[np.uint64]

# Magnitudes of residuals are sorted into bins: one for each value previous_byte 16, above that 8 for each
# octave.
_EXACT_MAGNITUDES, _BINS_PER_OCTAVE = 16, 8
_BINS = _EXACT_MAGNITUDES + 60 * _BINS_PER_OCTAVE  # up to 2^64
_MIN_SCALE_EXPONENT = -3  # exponent of 2 of the smallest scale [counts]: a constant value
_MAX_TABLE_VALUES = 48  # distinct values up to which a transition table is coded (bounds its size)
_MAX_INT64 = np.int64(2**63 - 1)
CODE_EXCESS = 0.03  # [bits per frame and byte] by which codes of numbers exceed optimal ones (assumption)
COUNTER_RANGE_BITS = 2.0  # [bits] prior of 1 in 4: half of the devices are encoders, half of these have 6002h
LEFT_JUSTIFIED_BITS = 3.0  # [bits] prior of 1 in 8: two of the objects in `priors` are left-justified
BYTE_RANGE = 256  # [counts] range of a whole byte: the field is the byte, not a wider counter
_EM_ROUNDS = 25  # iterations of expectation maximisation; the weights of the scales converge to 1e-3


class NumberCode(NamedTuple):
    """Code length of a column as one number, with the range of a counter."""

    steps: float  # code length of all values but the first, modulo the range of the number [bits]
    # value at which the counter restarts from 0 before its bits are full; 0 for none [counts]
    counter_range: int
    counter_range_odds: float  # log2 odds of that range against the full one [bits]
    unsigned_wraps: int  # number of steps over the end of the unsigned range
    signed_wraps: int  # number of steps over the end of the two's complement range


def little_endian(data: NDArray[np.uint8]) -> Column:
    """Return the data of frames, `(N, length)` bytes, as one little-endian number for each frame, `(N,)`."""
    padded = np.zeros((len(data), 8), np.uint8)
    padded[:, : data.shape[1]] = data
    return padded.view("<u8").reshape(-1).astype(np.uint64)


def to_signed(values: Column, bits: int) -> NDArray[np.int64]:
    """Return the lowest `bits` bits of values as two's complement numbers, `(N,)`.

    For a difference of two readings of a counter, this is the shortest of the possible steps.
    """
    shift = np.uint64(64 - bits)
    return (values << shift).view(np.int64) >> shift.astype(np.int64)


def number_code(values: Column, bits: int) -> NumberCode:
    """Return the code length of a column, `(N,)`, as a number of `bits` bits.

    A value is predicted from the previous one, from that plus the previous step or the median step, as the
    median of the column, or, for few distinct values, by a transition table. The shortest code is used, plus
    three bits for the choice. A counter may restart before its bits are full (6002h of CiA 406). A converter
    of fewer bits may be left-justified (6401h of CiA 401): its lowest bits are always zero.
    """
    if len(values) < 2:
        return NumberCode(0.0, 0, 0.0, 0, 0)
    zeros = trailing_zero_bits(values)
    if 0 < zeros < 8:
        code = number_code(values >> np.uint64(zeros), bits - zeros)
        return code._replace(
            steps=code.steps + LEFT_JUSTIFIED_BITS + math.log2(7), counter_range=code.counter_range << zeros
        )
    counter_range, cost, odds = _counter_range(values, bits)

    def centre(numbers: Column) -> NDArray[np.int64]:
        if not counter_range:
            return to_signed(numbers, bits)
        return (numbers.view(np.int64) + counter_range // 2) % counter_range - counter_range // 2

    step = centre(np.diff(values))
    lengths = [residual_code(step), residual_code(centre(np.diff(step, prepend=0).view(np.uint64)))]
    median_step = int(np.median(step))
    if median_step:
        residuals = residual_code(centre((step - median_step).view(np.uint64)))
        lengths.append(residuals + first_value(median_step, bits) + 1.0)
    deviation = centre(values - values[len(values) // 2])
    deviation -= np.int64(np.median(deviation))
    lengths.append(residual_code(deviation[1:]) + first_value(int(deviation[0]), bits) + 1.0)
    distinct = np.unique(deviation)
    span = int(distinct[-1]) - int(distinct[0]) + 1
    if span <= _MAX_TABLE_VALUES:  # the values between may occur, too
        lengths.append(_table_code(values) + 2.0 * math.log2(span + 1) + log2_choose(span, len(distinct)))
    signed = to_signed(values, bits)
    return NumberCode(
        min(lengths) + 3.0 + cost,
        counter_range,
        odds,
        int(np.count_nonzero((values[1:] > values[:-1]) != (step > 0))),
        int(np.count_nonzero((signed[1:] > signed[:-1]) != (step > 0))),
    )


def trailing_zero_bits(values: Column) -> int:
    """Return the number of lowest bits that are zero in all values, `(N,)`; 64 if all are zero."""
    any_set = int(np.bitwise_or.reduce(values))
    return (any_set & -any_set).bit_length() - 1 if any_set else 64


def _counter_range(values: Column, bits: int) -> tuple[int, float, float]:
    """Return the range of a counter, the bits to code it, and its log2 odds against the full range.

    The range is 0 if no step exceeds half of the highest value: the counter never restarted.
    """
    highest = int(values.max())
    if bits == 64 or not highest or highest.bit_length() > bits - 1:
        return 0, 0.0, 0.0
    step = to_signed(np.diff(values), bits)
    if 2 * int(np.abs(step).max()) <= highest:
        return 0, 0.0, 0.0
    choices = [(residual_code(step), 0, 0.0)]
    for counter_range, range_bits in (
        (1 << highest.bit_length(), math.log2(bits)),
        (_roundest_range(highest, step), float(bits)),
    ):
        cost = range_bits + COUNTER_RANGE_BITS
        length = residual_code((step + counter_range // 2) % counter_range - counter_range // 2)
        if counter_range != BYTE_RANGE:
            choices.append((length + cost, counter_range, cost))
    best = min(choices)
    return best[1], best[2], choices[0][0] - best[0]


def _roundest_range(highest: int, step: NDArray[np.int64]) -> int:
    """Return the roundest decimal range of a counter whose highest observed value is `highest`.

    The range exceeds that value by at most the median step. Ranges in 6002h are assumed to be round numbers,
    such as 3600 or 36000.
    """
    short = np.abs(step[np.abs(step) * 2 <= highest])
    margin = int(np.median(short)) if len(short) else 0
    unit = 1
    while highest // (10 * unit) * 10 * unit + 10 * unit <= highest + 1 + margin:
        unit *= 10
    return highest // unit * unit + unit


def first_value(value: int, bits: int) -> float:
    """Return the code length of a signed first value [bits]; all lengths in digits are equally likely."""
    return math.log2(bits + 1) + max(abs(value).bit_length() - 1, 0)


def flags_value(value: int, bits: int) -> float:
    """Return the code length of a value as a set of flags [bits]: how many of `bits` are set, and which.

    A mixture of two models: any number of flags is equally likely, or few are set.
    """
    count = value.bit_count()
    return 1.0 - math.log2(1.0 / (bits + 1) + 2.0 ** (-1 - count)) + log2_choose(bits, count)


def symbol_code(
    values: Column, bits: int, previous_byte: Column | None = None, *, new_values: bool = True
) -> float:
    """Return the code length of a column of states or flags without its first value [bits].

    The shorter of two models: the values are symbols with the frequencies observed so far (Krichevsky and
    Trofimov 1981), conditional on the previous value if there are few values; or every flag changes
    independently. A new value is coded by the flags in which it differs from the previous one. Flags that
    change in half of the frames may be the low byte of a number: `CODE_EXCESS` is added for them, because the
    codes of numbers exceed optimal ones by that much.

    Args:
        values: The column, `(N,)`.
        bits: Its width.
        previous_byte: The byte before the field, `(N,)`; its changes predict those of the field, because one
            cause, such as enabling a drive, changes several objects of a device. None for no such byte.
        new_values: Whether the code length of new values is included; otherwise the caller adds it.
    """
    flips = values[1:] ^ values[:-1]
    changed = np.flatnonzero(flips) + 1
    distinct, first, counts = np.unique(values[changed], return_index=True, return_counts=True)
    change_code = _binary_code(len(flips) - len(changed), len(changed))
    if previous_byte is not None:
        change_code = (
            min(change_code, _conditional_change_code(flips != 0, previous_byte[1:] != previous_byte[:-1]))
            + 1.0
        )
    joint_models = [change_code + _categorical_code(counts)]
    if 0 < len(distinct) < _MAX_TABLE_VALUES:
        joint_models += [change_code + _table_code(values[changed]), _table_code(values)]
    joint = min(joint_models)
    if new_values:
        sizes = np.bincount(_set_bits(flips[changed[first] - 1]), minlength=bits + 1)
        joint += float(sizes @ [flags_value((1 << size) - 1, bits) for size in range(bits + 1)])
    moves = [int(np.count_nonzero(flips >> np.uint64(bit) & np.uint64(1))) for bit in range(bits)]
    separate = sum(_binary_code(len(flips) - count, count) for count in moves if count)
    separate += flags_value((1 << sum(map(bool, moves))) - 1, bits)
    fair_flags = sum(0.4 * len(flips) < count < 0.6 * len(flips) for count in moves)
    return min(joint, separate) + 2.0 + CODE_EXCESS / 8 * fair_flags * len(flips)


def _conditional_change_code(changes: NDArray[np.bool_], others: NDArray[np.bool_]) -> float:
    """Return the code length of the changes of a field given those of another one, both `(N,)`."""
    both_change, only_this = (int(np.count_nonzero(changes & mask)) for mask in (others, ~others))
    other_changes = int(np.count_nonzero(others))
    # A field that changes only together with the other one needs no code for the frames between.
    between = _binary_code(len(others) - other_changes - only_this, only_this) if only_this else 0.0
    return 1.0 + _binary_code(other_changes - both_change, both_change) + between


def _set_bits(values: Column) -> NDArray[np.int64]:
    """Return the number of set bits of each value, `(N,)`."""
    set_bits: NDArray[np.int64] = np.unpackbits(values.view(np.uint8).reshape(-1, 8), axis=1).sum(
        axis=1, dtype=np.int64
    )
    return set_bits


def _table_code(values: Column) -> float:
    """Return the code length of a column, `(N,)`, by symbol frequencies conditional on the previous value."""
    number = np.unique(values, return_inverse=True)[1]
    size = int(number.max()) + 1
    follows = np.bincount(number[:-1] * size + number[1:], minlength=size * size).reshape(size, size)
    return sum(_categorical_code(row) for row in follows)


def log2_choose(size: int, chosen: int) -> float:
    """Return log2 of the binomial coefficient of `chosen` out of `size`."""
    nats = math.lgamma(size + 1) - math.lgamma(chosen + 1) - math.lgamma(size - chosen + 1)
    return nats / math.log(2.0)


def ordered_floats(values: Column) -> Column:
    """Return IEEE 754 single precision bits as whole numbers in the order of the values, `(N,)`."""
    magnitude = values & np.uint64(0x7FFFFFFF)
    half = np.uint64(1 << 31)
    return np.where(values >> np.uint64(31) > 0, half - magnitude, half + magnitude)


def residual_code(residual: NDArray[np.int64]) -> float:
    """Return the code length of prediction residuals, `(N,)`; those after a zero have a code of their own."""
    after_zero = np.concatenate(([True], residual[:-1] == 0))
    magnitude = np.abs(np.maximum(residual, -_MAX_INT64))
    bins = _bin(magnitude)
    total = 0.0
    for part in (bins[after_zero], bins[~after_zero]):
        if len(part):
            total += _scale_mixture_code(np.bincount(part, minlength=_BINS))
    is_negative = residual[residual != 0] < 0
    if len(is_negative):
        same = int(np.count_nonzero(is_negative[1:] == is_negative[:-1]))
        total += 1.0 + _binary_code(same, len(is_negative) - 1 - same)
    return total


def _bin(magnitude: NDArray[np.int64]) -> NDArray[np.int64]:
    octave = np.frexp(magnitude.astype(np.float64))[1].astype(np.int64) - 1
    eighth = magnitude >> np.maximum(octave - 3, 0) & 7
    return np.where(
        magnitude < _EXACT_MAGNITUDES, magnitude, _EXACT_MAGNITUDES + (octave - 4) * _BINS_PER_OCTAVE + eighth
    )


def _scale_mixture_code(counts: NDArray[np.int64]) -> float:
    """Return the code length of magnitudes, counted by bin in `(_BINS,)`, by a mixture of normals around 0.

    Their standard deviations are powers of the square root of 2. The weights are fitted by expectation
    maximisation; each one in use costs half of log2 of the number of values (Rissanen 1978).
    """
    used = np.flatnonzero(counts)
    masses, wide = _bin_probabilities()
    number = counts[used].astype(np.float64)
    total = float(number.sum())
    largest = int(used[-1])
    width = 2 * (
        int(np.ceil(np.log2(largest + 1.0 if largest < _EXACT_MAGNITUDES else 2.0 ** wide[largest] * 16)))
        - _MIN_SCALE_EXPONENT
        + 1
    )
    table = masses[used, :width]
    weights = np.full(table.shape[1], 1.0 / table.shape[1])
    for _ in range(_EM_ROUNDS):
        density = table @ weights
        weights *= (number / density) @ table / total
    in_use = int(np.count_nonzero(weights * total > 1.0))
    length = -float(number @ np.log2(table @ weights)) + float(number @ wide[used])
    return length + in_use * 0.5 * math.log2(total + 1.0)


@cache
def _bin_probabilities() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return probabilities of bins, `(_BINS, scales)`, and bits of a value within its bin, `(_BINS,)`."""
    low = np.arange(_BINS, dtype=np.float64)
    size = np.ones(_BINS)
    for index in range(_EXACT_MAGNITUDES, _BINS):
        octave, eighth = divmod(index - _EXACT_MAGNITUDES, _BINS_PER_OCTAVE)
        size[index] = 2.0 ** (octave + 1)
        low[index] = (8 + eighth) * size[index]
    scales = [2.0 ** (half / 2) for half in range(2 * _MIN_SCALE_EXPONENT, 128)]
    table = np.array(
        [
            [
                math.erfc((max(start - 0.5, 0.0)) / scale / math.sqrt(2.0))
                - math.erfc((start + width - 0.5) / scale / math.sqrt(2.0))
                for scale in scales
            ]
            for start, width in zip(low, size, strict=True)
        ]
    )
    return table + 1e-30, np.log2(size)


def _binary_code(one: int, other: int) -> float:
    """Return the code length of a binary sequence by its counts of both symbols (Krichevsky and Trofimov)."""
    nats = (
        math.lgamma(one + other + 1) + math.log(math.pi) - math.lgamma(one + 0.5) - math.lgamma(other + 0.5)
    )
    return nats / math.log(2.0)


def _categorical_code(counts: NDArray[np.int64]) -> float:
    """Return the code length of a sequence in which symbol k occurs `counts[k]` times, likewise."""
    if len(counts) < 2:
        return 0.0
    half, total = 0.5 * len(counts), int(counts.sum())
    multiplicities = np.bincount(counts)  # how many symbols have each count: many have the same small one
    sizes = np.flatnonzero(multiplicities)
    nats: float = math.lgamma(total + half) - math.lgamma(half) + len(counts) * math.lgamma(0.5)
    nats -= math.fsum(
        times * math.lgamma(size + 0.5)
        for size, times in zip(sizes.tolist(), multiplicities[sizes].tolist(), strict=True)
    )
    return nats / math.log(2.0)
