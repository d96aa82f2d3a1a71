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

_EXACT_MAGNITUDES, _BINS_PER_OCTAVE = 16, 8  # magnitudes with one bin each; bins per octave above them
_BINS = _EXACT_MAGNITUDES + 60 * _BINS_PER_OCTAVE
_MIN_SCALE_EXPONENT = -3  # exponent of 2 of the smallest scale [counts]: a constant value
_MAX_TABLE_VALUES = 48  # distinct values up to which a transition table is coded (bounds its size)
_MAX_INT64 = np.int64(2**63 - 1)
CODE_EXCESS = 0.03  # [bits per frame and byte] excess of these codes of numbers over optimal ones
TURN_BITS = 2.0  # [bits] prior of 1 in 4: every second device is an encoder, every second of them has 6002h
LEFT_JUSTIFIED_BITS = 3.0  # [bits] prior of 1 in 8: two of the objects in `priors` are left-justified
BYTE_RANGE = 256  # a range of 256 is the byte itself, not a wider counter
_EM_ROUNDS = 25  # of expectation maximisation; weights of scales converge to 1e-3


class NumberCode(NamedTuple):
    """Lengths of a column as one number.

    Attributes:
        steps: Bits for all values but the first, on the ring on which the number counts.
        turn: Range after which the counter restarts before its bits are full; 0 for none.
        turn_odds: log2 odds of that range.
        unsigned_wraps: Steps over the end of the unsigned range.
        signed_wraps: Steps over the end of the two's complement range.
    """

    steps: float
    turn: int
    turn_odds: float
    unsigned_wraps: int
    signed_wraps: int


def little_endian(data: NDArray[np.uint8]) -> Column:
    """Return data of frames, `(N, length)`, as one little-endian number a frame, `(N,)`."""
    padded = np.zeros((len(data), 8), np.uint8)
    padded[:, : data.shape[1]] = data
    return padded.view("<u8").reshape(-1).astype(np.uint64)


def to_signed(values: Column, bits: int) -> NDArray[np.int64]:
    """Return values modulo 2^bits as two's complement numbers, the shortest distance on the ring, `(N,)`."""
    left = np.uint64(64 - bits)
    return (values << left).view(np.int64) >> left.astype(np.int64)


def number_code(values: Column, bits: int) -> NumberCode:
    """Return the code lengths of a column, `(N,)`, as a number of `bits` bits.

    Predictors are the previous value, that plus the previous step, that plus the median step, the median of
    the column, and for few distinct values a transition table. The shortest code is used, plus three bits for
    the choice. A counter may restart before its bits are full (6002h of CiA 406). A converter of fewer bits
    may be left-justified (6401h of CiA 401): its lowest bits are always zero.
    """
    if len(values) < 2:
        return NumberCode(0.0, 0, 0.0, 0, 0)
    zeros = trailing_zero_bits(values)
    if 0 < zeros < 8:
        code = number_code(values >> np.uint64(zeros), bits - zeros)
        return code._replace(steps=code.steps + LEFT_JUSTIFIED_BITS + math.log2(7), turn=code.turn << zeros)
    turn, cost, odds = _counter_range(values, bits)

    def centre(numbers: Column) -> NDArray[np.int64]:
        if not turn:
            return to_signed(numbers, bits)
        return (numbers.view(np.int64) + turn // 2) % turn - turn // 2

    step = centre(np.diff(values))
    lengths = [residual_code(step), residual_code(centre(np.diff(step, prepend=0).view(np.uint64)))]
    median_step = int(np.median(step))
    if median_step:
        rest = residual_code(centre((step - median_step).view(np.uint64)))
        lengths.append(rest + first_value(median_step, bits) + 1.0)
    far = centre(values - values[len(values) // 2])
    far -= np.int64(np.median(far))
    lengths.append(residual_code(far[1:]) + first_value(int(far[0]), bits) + 1.0)
    distinct = np.unique(far)
    span = int(distinct[-1]) - int(distinct[0]) + 1
    if span <= _MAX_TABLE_VALUES:  # a number takes the values between, too
        lengths.append(_table_code(values) + 2.0 * math.log2(span + 1) + log2_choose(span, len(distinct)))
    signed = to_signed(values, bits)
    return NumberCode(
        min(lengths) + 3.0 + cost,
        turn,
        odds,
        int(np.count_nonzero((values[1:] > values[:-1]) != (step > 0))),
        int(np.count_nonzero((signed[1:] > signed[:-1]) != (step > 0))),
    )


def trailing_zero_bits(values: Column) -> int:
    """Return the number of lowest bits that are zero in all values, `(N,)`; 64 if all are zero."""
    any_set = int(np.bitwise_or.reduce(values))
    return (any_set & -any_set).bit_length() - 1 if any_set else 64


def _counter_range(values: Column, bits: int) -> tuple[int, float, float]:
    """Return the range of a counter, the bits to code it, and its log2 odds.

    The range is 0 for none: only a step of more than half of the observed range can be a restart.
    """
    highest = int(values.max())
    if bits == 64 or not highest or highest.bit_length() > bits - 1:
        return 0, 0.0, 0.0
    step = to_signed(np.diff(values), bits)
    if 2 * int(np.abs(step).max()) <= highest:
        return 0, 0.0, 0.0
    choices = [(residual_code(step), 0, 0.0)]
    for turn, cost in (
        (1 << highest.bit_length(), math.log2(bits)),
        (_roundest_range(highest, step), float(bits)),
    ):
        length = residual_code((step + turn // 2) % turn - turn // 2)
        if turn != BYTE_RANGE:
            choices.append((length + cost + TURN_BITS, turn, cost + TURN_BITS))
    best = min(choices)
    return best[1], best[2], choices[0][0] - best[0]


def _roundest_range(highest: int, step: NDArray[np.int64]) -> int:
    """Return the roundest decimal range of a counter whose highest observed value is `highest`.

    The range exceeds that value by at most a step. A range in 6002h is a round number: 3600, 36000.
    """
    short = np.abs(step[np.abs(step) * 2 <= highest])
    span = int(np.median(short)) if len(short) else 0
    unit = 1
    while highest // (10 * unit) * 10 * unit + 10 * unit <= highest + 1 + span:
        unit *= 10
    return highest // unit * unit + unit


def first_value(value: int, bits: int) -> float:
    """Return the code length of a first value of either sign: all binary magnitudes are equally likely."""
    return math.log2(bits + 1) + max(abs(value).bit_length() - 1, 0)


def flags_value(value: int, bits: int) -> float:
    """Return the code length of a set of flags: their number, and which are set.

    A mixture of two models: any number of flags is equally likely, or few are set.
    """
    count = value.bit_count()
    return 1.0 - math.log2(1.0 / (bits + 1) + 2.0 ** (-1 - count)) + log2_choose(bits, count)


def symbol_code(values: Column, bits: int, below: Column | None = None, *, new_values: bool = True) -> float:
    """Return the code length of a column of states or flags after its first value.

    The models: the value changes with the frequency so far (Krichevsky and Trofimov 1981), conditional on the
    previous value if there are few; or every flag changes independently. A new value is coded by the flags in
    which it differs from the previous one. Flags that change in half of the frames may be the low byte of a
    number; they cost `CODE_EXCESS` more, because the codes are not exact to that.

    Args:
        values: The column, `(N,)`.
        bits: Its width.
        below: The byte before the field, `(N,)`, as a predictor of changes: one cause, such as enabling a
            drive, changes several objects of a device. None for no such byte.
        new_values: Whether new values are coded; otherwise the caller adds their cost.
    """
    flips = values[1:] ^ values[:-1]
    changed = np.flatnonzero(flips) + 1
    distinct, first, counts = np.unique(values[changed], return_index=True, return_counts=True)
    stays = _binary_code(len(flips) - len(changed), len(changed))
    if below is not None:
        stays = min(stays, _conditional_change_code(flips != 0, below[1:] != below[:-1])) + 1.0
    orders = [stays + _categorical_code(counts)]
    if 0 < len(distinct) < _MAX_TABLE_VALUES:
        orders += [stays + _table_code(values[changed]), _table_code(values)]
    joint = min(orders)
    if new_values:
        sizes = np.bincount(_set_bits(flips[changed[first] - 1]), minlength=bits + 1)
        joint += float(sizes @ [flags_value((1 << size) - 1, bits) for size in range(bits + 1)])
    moves = [int(np.count_nonzero(flips >> np.uint64(bit) & np.uint64(1))) for bit in range(bits)]
    separate = sum(_binary_code(len(flips) - count, count) for count in moves if count)
    separate += flags_value((1 << sum(map(bool, moves))) - 1, bits)
    coins = sum(0.4 * len(flips) < count < 0.6 * len(flips) for count in moves)
    return min(joint, separate) + 2.0 + CODE_EXCESS / 8 * coins * len(flips)


def _conditional_change_code(changes: NDArray[np.bool_], others: NDArray[np.bool_]) -> float:
    """Return the code length of the changes of a field given those of another one, both `(N,)`."""
    together, alone = (int(np.count_nonzero(changes & mask)) for mask in (others, ~others))
    known = int(np.count_nonzero(others))
    never = (
        _binary_code(len(others) - known - alone, alone) if alone else 0.0
    )  # but where the other one changes
    return 1.0 + _binary_code(known - together, together) + never


def _set_bits(values: Column) -> NDArray[np.int64]:
    """Return the number of set bits of each value, `(N,)`."""
    set_bits: NDArray[np.int64] = np.unpackbits(values.view(np.uint8).reshape(-1, 8), axis=1).sum(
        axis=1, dtype=np.int64
    )
    return set_bits


def _table_code(values: Column) -> float:
    """Return the code length of a column by a table of transitions."""
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
    """Return the code length of prediction residuals, with separate codes after a zero and otherwise."""
    before = np.concatenate(([True], residual[:-1] == 0))
    magnitude = np.abs(np.maximum(residual, -_MAX_INT64))
    bins = _bin(magnitude)
    total = 0.0
    for part in (bins[before], bins[~before]):
        if len(part):
            total += _scale_mixture_code(np.bincount(part, minlength=_BINS))
    sign = residual[residual != 0] < 0
    if len(sign):
        same = int(np.count_nonzero(sign[1:] == sign[:-1]))
        total += 1.0 + _binary_code(same, len(sign) - 1 - same)
    return total


def _bin(magnitude: NDArray[np.int64]) -> NDArray[np.int64]:
    octave = np.frexp(magnitude.astype(np.float64))[1].astype(np.int64) - 1
    share = magnitude >> np.maximum(octave - 3, 0) & 7
    return np.where(
        magnitude < _EXACT_MAGNITUDES, magnitude, _EXACT_MAGNITUDES + (octave - 4) * _BINS_PER_OCTAVE + share
    )


def _scale_mixture_code(counts: NDArray[np.int64]) -> float:
    """Return the code length of magnitudes, as counts of bins, by a mixture of normal distributions.

    Scales are powers of the square root of 2; each used one costs half of log2 of the number of values.
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
    """Return the probability of each bin by each scale, and the bits of a value inside its bin."""
    low = np.arange(_BINS, dtype=np.float64)
    size = np.ones(_BINS)
    for index in range(_EXACT_MAGNITUDES, _BINS):
        octave, share = (
            4 + (index - _EXACT_MAGNITUDES) // _BINS_PER_OCTAVE,
            (index - _EXACT_MAGNITUDES) % _BINS_PER_OCTAVE,
        )
        size[index] = 2.0 ** (octave - 3)
        low[index] = (8 + share) * size[index]
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
    """Return the code length of a binary sequence of unknown frequency (Krichevsky and Trofimov)."""
    nats = (
        math.lgamma(one + other + 1) + math.log(math.pi) - math.lgamma(one + 0.5) - math.lgamma(other + 0.5)
    )
    return nats / math.log(2.0)


def _categorical_code(counts: NDArray[np.int64]) -> float:
    """Return the code length of a sequence with these counts of symbols."""
    if len(counts) < 2:
        return 0.0
    half, total = 0.5 * len(counts), int(counts.sum())
    often = np.bincount(counts)  # counts of counts: most symbols are rare
    sizes = np.flatnonzero(often)
    nats: float = math.lgamma(total + half) - math.lgamma(half) + len(counts) * math.lgamma(0.5)
    nats -= math.fsum(
        times * math.lgamma(size + 0.5)
        for size, times in zip(sizes.tolist(), often[sizes].tolist(), strict=True)
    )
    return nats / math.log(2.0)
