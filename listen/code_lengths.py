"""How many bits a column of raw values takes to write down, by what it may be.

The shorter description is the more probable one: a code of length L has probability 2^-L (Rissanen,
"Modeling by shortest data description", Automatica 14, 1978). No code has a parameter that was tuned: what a
code must learn from the column itself, it pays for.
"""

from __future__ import annotations

import math
from functools import cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Column = NDArray[np.uint64]

_EXACT, _SHARES = 16, 8  # magnitudes with a bin of their own; bins of each octave above them
_BINS = _EXACT + 60 * _SHARES
_SMALLEST = -3  # the finest scale is an eighth of a count: a value that stands still
_TABLE = 48  # values of which a table of what follows what is made
_LARGEST = np.int64(2**63 - 1)
NOISE = 0.03  # bits per frame and byte by which the codes of numbers here are longer than the best ones
TURN = 2.0  # bits of 1 in 4: 6002h is there in every second encoder, and every second device is a drive
LEFT_JUSTIFIED = (
    3.0  # bits of 1 in 8: two of the objects in `priors` are so, where a converter has fewer bits
)
BYTE = 256  # counts after which a byte starts again: it is one, and no wider number that ends there
_ROUNDS = 25  # of expectation maximisation; the weights of scales have settled to a part in a thousand


class NumberCode(NamedTuple):
    """Lengths of a column as one number.

    Attributes:
        steps: Bits for all values but the first, on the ring on which the number counts.
        turn: Counts after which it starts again, where that is before its bits are full; else 0.
        turn_odds: Logarithm (base 2) of the odds that it does.
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


def centred(values: Column, bits: int) -> NDArray[np.int64]:
    """Return values modulo 2^bits as two's complement numbers, the shortest distance on the ring, `(N,)`."""
    left = np.uint64(64 - bits)
    return (values << left).view(np.int64) >> left.astype(np.int64)


def number_code(values: Column, bits: int) -> NumberCode:
    """Return the code lengths of a column, `(N,)`, that is a number of so many bits.

    Each value is predicted by the one before, by it and the step before, by it and the usual step, or by the
    column's median; or, where there are few values, by a table of what follows what. The best counts, and
    three bits say which. A counter may start again before its bits are full, as CiA 406's 6002h sets it. A
    converter of fewer bits may be left-justified, as CiA 401 says of 6401h: its lowest bits are always zero.
    """
    if len(values) < 2:
        return NumberCode(0.0, 0, 0.0, 0, 0)
    zeros = lowest_zeros(values)
    if 0 < zeros < 8:
        code = number_code(values >> np.uint64(zeros), bits - zeros)
        return code._replace(steps=code.steps + LEFT_JUSTIFIED + math.log2(7), turn=code.turn << zeros)
    turn, cost, odds = _turn(values, bits)

    def centre(numbers: Column) -> NDArray[np.int64]:
        if not turn:
            return centred(numbers, bits)
        return (numbers.view(np.int64) + turn // 2) % turn - turn // 2

    step = centre(np.diff(values))
    lengths = [residual_code(step), residual_code(centre(np.diff(step, prepend=0).view(np.uint64)))]
    usual = int(np.median(step))
    if usual:
        rest = residual_code(centre((step - usual).view(np.uint64)))
        lengths.append(rest + first_value(usual, bits) + 1.0)
    far = centre(values - values[len(values) // 2])
    far -= np.int64(np.median(far))
    lengths.append(residual_code(far[1:]) + first_value(int(far[0]), bits) + 1.0)
    distinct = np.unique(far)
    span = int(distinct[-1]) - int(distinct[0]) + 1
    if span <= _TABLE:  # a number takes the values between, too
        lengths.append(_table_code(values) + 2.0 * math.log2(span + 1) + log2_choose(span, len(distinct)))
    signed = centred(values, bits)
    return NumberCode(
        min(lengths) + 3.0 + cost,
        turn,
        odds,
        int(np.count_nonzero((values[1:] > values[:-1]) != (step > 0))),
        int(np.count_nonzero((signed[1:] > signed[:-1]) != (step > 0))),
    )


def lowest_zeros(values: Column) -> int:
    """Return how many of the lowest bits are zero in all values, `(N,)`; 64 where all bits are."""
    any_set = int(np.bitwise_or.reduce(values))
    return (any_set & -any_set).bit_length() - 1 if any_set else 64


def _turn(values: Column, bits: int) -> tuple[int, float, float]:
    """Return the counts after which a counter starts again, the bits to say so, and the odds that it does.

    That is 0 where it does not: only a step of more than half of what was seen can be such a start.
    """
    highest = int(values.max())
    if bits == 64 or not highest or highest.bit_length() > bits - 1:
        return 0, 0.0, 0.0
    step = centred(np.diff(values), bits)
    if 2 * int(np.abs(step).max()) <= highest:
        return 0, 0.0, 0.0
    choices = [(residual_code(step), 0, 0.0)]
    for turn, cost in ((1 << highest.bit_length(), math.log2(bits)), (_roundest(highest, step), float(bits))):
        length = residual_code((step + turn // 2) % turn - turn // 2)
        if turn != BYTE:
            choices.append((length + cost + TURN, turn, cost + TURN))
    best = min(choices)
    return best[1], best[2], choices[0][0] - best[0]


def _roundest(highest: int, step: NDArray[np.int64]) -> int:
    """Return the roundest decimal number at which a counter may start again that was seen up to `highest`.

    It was not seen further than its steps are long. A range in 6002h is a choice of people: 3600, 36000.
    """
    short = np.abs(step[np.abs(step) * 2 <= highest])
    span = int(np.median(short)) if len(short) else 0
    unit = 1
    while highest // (10 * unit) * 10 * unit + 10 * unit <= highest + 1 + span:
        unit *= 10
    return highest // unit * unit + unit


def first_value(value: int, bits: int) -> float:
    """Return the bits of a first value of either sign: all binary orders of magnitude are alike to it."""
    return math.log2(bits + 1) + max(abs(value).bit_length() - 1, 0)


def flags_value(value: int, bits: int) -> float:
    """Return the bits of a set of flags: as many as are set, and which.

    One of two numbers of flags is as good as any, the other one has few flags set.
    """
    count = value.bit_count()
    return 1.0 - math.log2(1.0 / (bits + 1) + 2.0 ** (-1 - count)) + log2_choose(bits, count)


def symbol_code(values: Column, bits: int, below: Column | None = None, *, new_values: bool = True) -> float:
    """Return the code length of a column of states or flags behind its first value.

    Flags that are tossed like coins are the low byte of a number, which only its high byte identifies; the
    codes are not exact enough to decide by `NOISE` bits a frame.

    It stays, or changes to some other value, as often as it did before (Krichevsky and Trofimov 1981), after
    each value separately where there are few; or every flag changes for itself. A value that is new is coded
    by the flags in which it differs from the one before.

    Args:
        values: The column, `(N,)`.
        bits: Its width.
        below: The byte before the field, `(N,)`, which predicts when a change comes: one cause, such as a
            drive that is enabled, changes several objects of a device. None for a field without one.
        new_values: Whether new values are counted; else the caller knows what they cost.
    """
    flips = values[1:] ^ values[:-1]
    changed = np.flatnonzero(flips) + 1
    distinct, first, counts = np.unique(values[changed], return_index=True, return_counts=True)
    stays = _two_way(len(flips) - len(changed), len(changed))
    if below is not None:
        stays = min(stays, _changes_with(flips != 0, below[1:] != below[:-1])) + 1.0
    orders = [stays + _many_way(counts)]
    if 0 < len(distinct) < _TABLE:
        orders += [stays + _table_code(values[changed]), _table_code(values)]
    joint = min(orders)
    if new_values:
        sizes = np.bincount(_set_bits(flips[changed[first] - 1]), minlength=bits + 1)
        joint += float(sizes @ [flags_value((1 << size) - 1, bits) for size in range(bits + 1)])
    moves = [int(np.count_nonzero(flips >> np.uint64(bit) & np.uint64(1))) for bit in range(bits)]
    each = sum(_two_way(len(flips) - count, count) for count in moves if count)
    each += flags_value((1 << sum(map(bool, moves))) - 1, bits)
    coins = sum(0.4 * len(flips) < count < 0.6 * len(flips) for count in moves)
    return min(joint, each) + 2.0 + NOISE / 8 * coins * len(flips)


def _changes_with(changes: NDArray[np.bool_], others: NDArray[np.bool_]) -> float:
    """Return the bits of when a field changes, where it is known when another one does, both `(N,)`."""
    together, alone = (int(np.count_nonzero(changes & each)) for each in (others, ~others))
    known = int(np.count_nonzero(others))
    never = _two_way(len(others) - known - alone, alone) if alone else 0.0  # but where the other one changes
    return 1.0 + _two_way(known - together, together) + never


def _set_bits(values: Column) -> NDArray[np.int64]:
    """Return how many bits are set in each value, `(N,)`."""
    set_bits: NDArray[np.int64] = np.unpackbits(values.view(np.uint8).reshape(-1, 8), axis=1).sum(
        axis=1, dtype=np.int64
    )
    return set_bits


def _table_code(values: Column) -> float:
    """Return the bits of a column by a table of how often each value followed each other."""
    number = np.unique(values, return_inverse=True)[1]
    size = int(number.max()) + 1
    follows = np.bincount(number[:-1] * size + number[1:], minlength=size * size).reshape(size, size)
    return sum(_many_way(row) for row in follows)


def log2_choose(size: int, chosen: int) -> float:
    """Return the logarithm (base 2) of the number of choices of so many out of a set."""
    nats = math.lgamma(size + 1) - math.lgamma(chosen + 1) - math.lgamma(size - chosen + 1)
    return nats / math.log(2.0)


def ordered_floats(values: Column) -> Column:
    """Return IEEE 754 single precision bits as whole numbers in the order of the values, `(N,)`."""
    magnitude = values & np.uint64(0x7FFFFFFF)
    half = np.uint64(1 << 31)
    return np.where(values >> np.uint64(31) > 0, half - magnitude, half + magnitude)


def residual_code(residual: NDArray[np.int64]) -> float:
    """Return the bits of what a prediction leaves, with one code for after a zero and one for the rest."""
    before = np.concatenate(([True], residual[:-1] == 0))
    magnitude = np.abs(np.maximum(residual, -_LARGEST))
    bins = _bin(magnitude)
    total = 0.0
    for part in (bins[before], bins[~before]):
        if len(part):
            total += _scales(np.bincount(part, minlength=_BINS))
    sign = residual[residual != 0] < 0
    if len(sign):
        same = int(np.count_nonzero(sign[1:] == sign[:-1]))
        total += 1.0 + _two_way(same, len(sign) - 1 - same)
    return total


def _bin(magnitude: NDArray[np.int64]) -> NDArray[np.int64]:
    octave = np.frexp(magnitude.astype(np.float64))[1].astype(np.int64) - 1
    share = magnitude >> np.maximum(octave - 3, 0) & 7
    return np.where(magnitude < _EXACT, magnitude, _EXACT + (octave - 4) * _SHARES + share)


def _scales(counts: NDArray[np.int64]) -> float:
    """Return the bits of magnitudes, given as counts of bins, by the best mixture of normal distributions.

    Scales are powers of the square root of 2; each in use costs half a logarithm of the number of values.
    """
    used = np.flatnonzero(counts)
    masses, wide = _masses()
    number = counts[used].astype(np.float64)
    total = float(number.sum())
    largest = int(used[-1])
    width = 2 * (
        int(np.ceil(np.log2(largest + 1.0 if largest < _EXACT else 2.0 ** wide[largest] * 16)))
        - _SMALLEST
        + 1
    )
    table = masses[used, :width]
    weights = np.full(table.shape[1], 1.0 / table.shape[1])
    for _ in range(_ROUNDS):
        density = table @ weights
        weights *= (number / density) @ table / total
    in_use = int(np.count_nonzero(weights * total > 1.0))
    length = -float(number @ np.log2(table @ weights)) + float(number @ wide[used])
    return length + in_use * 0.5 * math.log2(total + 1.0)


@cache
def _masses() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the probability of each bin by each scale, and the bits of a value inside its bin."""
    low = np.arange(_BINS, dtype=np.float64)
    size = np.ones(_BINS)
    for index in range(_EXACT, _BINS):
        octave, share = 4 + (index - _EXACT) // _SHARES, (index - _EXACT) % _SHARES
        size[index] = 2.0 ** (octave - 3)
        low[index] = (8 + share) * size[index]
    scales = [2.0 ** (half / 2) for half in range(2 * _SMALLEST, 128)]
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


def _two_way(one: int, other: int) -> float:
    """Return the bits of a row of two symbols whose frequency is not known (Krichevsky and Trofimov)."""
    nats = (
        math.lgamma(one + other + 1) + math.log(math.pi) - math.lgamma(one + 0.5) - math.lgamma(other + 0.5)
    )
    return nats / math.log(2.0)


def _many_way(counts: NDArray[np.int64]) -> float:
    """Return the bits of a row of symbols that came so often."""
    if len(counts) < 2:
        return 0.0
    half, total = 0.5 * len(counts), int(counts.sum())
    often = np.bincount(counts)  # how many symbols came how often: most came seldom
    sizes = np.flatnonzero(often)
    nats: float = math.lgamma(total + half) - math.lgamma(half) + len(counts) * math.lgamma(0.5)
    nats -= math.fsum(
        times * math.lgamma(size + 0.5)
        for size, times in zip(sizes.tolist(), often[sizes].tolist(), strict=True)
    )
    return nats / math.log(2.0)
