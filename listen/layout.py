"""Segmentation of a message into fields: the posterior probability of layouts by code lengths.

A layout is a sequence of fields that fills the message. Its weight is the product over its fields of the
prior of kind and width (`priors`) and 2^-L, with L the code length of the field's column (`code_lengths`).
The sum over all layouts is computed by the forward and backward recursion of hidden Markov models (Rabiner
1989). The probability of a field is the weight of all layouts that contain it, divided by that sum.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.listen import priors
from omnimate.listen.code_lengths import (
    first_value,
    flags_value,
    little_endian,
    number_code,
    ordered_floats,
    residual_code,
    symbol_code,
    to_signed,
    trailing_zero_bits,
)
from omnimate.listen.profile_words import control_bits, status_bits

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from numpy.typing import NDArray

    from omnimate.listen.code_lengths import Column
    from omnimate.listen.priors import Direction, Kind

LOG_ZERO = float("-inf")
# [1] ratio of the flip rates of two neighbouring bits, for a boundary inside a byte (assumption)
MIN_RATE_RISE = 4.0
MAX_INNER_EDGES = 6  # boundaries inside bytes that are tried, which limits the computing time
MIN_FLIP_FRAMES = 100  # frames needed to estimate the flip rate of a bit (assumption)
MAX_PENALISED_WRAPS = 8  # wraps that count against a sign; a counter may have any number of them (assumption)
MAX_MANTISSA_ZEROS = 16  # [bits] trailing zeros of a float's mantissa that shorten its code
COUNTER_BITS = 2.0  # [bits] prior of 1 in 4: a number that crosses 0 and the middle of its range is a counter
MAX_WORD_VALUES = 64  # distinct values of a status or control word in a log (assumption)
Reading = tuple["Kind", bool | None]  # kind, and whether it is signed; None for kinds without a sign


@dataclass(frozen=True, slots=True)
class Field:
    """A field of a layout."""

    start: int  # its lowest bit in the number that all bytes of the message make in its byte order
    bits: int
    is_big_endian: bool  # whether its byte order is big-endian
    probability: float  # probability of exactly this field [0 to 1]
    readings: Mapping[Reading, float]  # probability of each kind and sign, given the field; they add up to 1


@dataclass(frozen=True, slots=True)
class Layout:
    """The most probable layout of a message."""

    fields: tuple[Field, ...]  # its fields in the order of their bits
    big_endian_probability: float  # probability of the big-endian order [0 to 1]
    log2_evidence: float  # log2 of the joint probability of data and layouts, summed over all layouts


def find_layout(
    data: NDArray[np.uint8],
    *,
    direction: Direction = "unknown",
    big_endian_prior: float = priors.BIG_ENDIAN,
    packed_prior: float = priors.PACKED,
) -> Layout:
    """Return the most probable layout of a message.

    Args:
        data: Data of its frames in the order of time, shape `(N, length)`.
        direction: Whether the node sends or receives it, by its identifier.
        big_endian_prior: Prior probability of the big-endian order [0 to 1].
        packed_prior: Prior probability of widths that no profile has [0 to 1].
    """
    tables = [_Table(little_endian(entry), entry.shape[1], direction) for entry in (data, data[:, ::-1])]
    hypotheses = [
        _Layouts(table, is_big, is_packed, math.log2(order) + math.log2(widths))
        for table, is_big, order in (
            (tables[0], False, 1.0 - big_endian_prior),
            (tables[1], True, big_endian_prior),
        )
        for is_packed, widths in ((False, 1.0 - packed_prior), (True, packed_prior))
    ]
    whole = log2_sum(entry.total for entry in hypotheses)
    shares = [2.0 ** (entry.total - whole) for entry in hypotheses]
    big = shares[2] + shares[3]
    same_order = [k for k in range(4) if hypotheses[k].is_big_endian == (big > 0.5)]
    best = max((hypotheses[k] for k in same_order), key=lambda entry: entry.best_weight)
    order = sum(shares[k] for k in same_order)
    fields = tuple(
        Field(
            best.table.edges[start],
            best.table.edges[end] - best.table.edges[start],
            best.is_big_endian,
            min(sum(shares[k] * hypotheses[k].share(start, end) for k in same_order) / order, 1.0),
            best.readings(start, end),
        )
        for start, end in best.path()
    )
    return Layout(fields, big, whole)


def reading_weights(
    column: Column, bits: int, direction: Direction, previous_byte: Column | None = None
) -> dict[Reading, float]:
    """Return log2 of the joint probability of kind and data for each reading of a field's column.

    Args:
        column: The field's values, `(N,)`.
        bits: Its width.
        direction: Whether the node sends or receives the message.
        previous_byte: The byte before the field, `(N,)`; None for no such byte.
    """
    if len(column) == 0 or np.all(column == column[0]):
        return _constant_readings(column, bits, direction)
    weights: dict[Reading, float] = {}
    code = number_code(column, bits)
    wraps_anyway = min(code.unsigned_wraps, code.signed_wraps) > 0  # a counter: its sign cannot be identified
    for signed, wraps in ((False, code.unsigned_wraps), (True, code.signed_wraps)):
        first = int(to_signed(column[:1], bits)[0]) if signed else int(column[0])
        jumps = COUNTER_BITS if wraps_anyway else min(wraps, MAX_PENALISED_WRAPS) * bits
        if code.counter_range:
            first, jumps = min(first % code.counter_range, -first % code.counter_range), 0.0
        length = first_value(first, bits) + signed + code.steps + jumps
        weights["number", signed] = _prior("number", bits, direction) - 1.0 - length
    start = flags_value(int(column[0]), bits)
    weights["bits", None] = _prior("bits", bits, direction) - start - symbol_code(column, bits, previous_byte)
    if bits == 16:
        _add_profile_words(weights, column, direction, previous_byte)
    if bits == 32:
        _add_float(weights, column, direction)
    return {reading: weight for reading, weight in weights.items() if weight > LOG_ZERO}


def _constant_readings(column: Column, bits: int, direction: Direction) -> dict[Reading, float]:
    value = int(column[0]) if len(column) else 0
    length = (
        -math.log2(priors.ZERO_SHARE)
        if value == 0
        else -math.log2(1 - priors.ZERO_SHARE) + first_value(value, bits)
    )
    weights: dict[Reading, float] = {("constant", None): _prior("constant", bits, direction) - length}
    if bits == 16:
        weights["status word", None] = _prior("status word", bits, direction) - status_bits(column[:1])
        weights["control word", None] = _prior("control word", bits, direction) - control_bits(column[:1])
    return {reading: weight for reading, weight in weights.items() if weight > LOG_ZERO}


def _add_profile_words(
    weights: dict[Reading, float], column: Column, direction: Direction, previous_byte: Column | None
) -> None:
    distinct, first = np.unique(column, return_index=True)
    if len(distinct) > MAX_WORD_VALUES:
        return
    in_order = distinct[np.argsort(first)]
    changes = symbol_code(column, 16, previous_byte, new_values=False)
    weights["status word", None] = _prior("status word", 16, direction) - changes - status_bits(in_order)
    weights["control word", None] = _prior("control word", 16, direction) - changes - control_bits(in_order)


def _add_float(weights: dict[Reading, float], column: Column, direction: Direction) -> None:
    exponents = (column >> np.uint64(23) & np.uint64(0xFF)).astype(np.int64)
    is_zero = column & np.uint64(0x7FFFFFFF) == 0
    if np.any(exponents == 255) or np.any((exponents == 0) & ~is_zero) or np.all(is_zero):
        return
    used = exponents[~is_zero]
    # The exponent of the largest value has a geometric prior on both sides of 2^2 (biased exponent 129),
    # which halves every three octaves; 3.1 bits normalise it. Sign and mantissa of the first value have 24
    # bits.
    octaves = abs(int(used.max()) - 129)
    step = to_signed(np.diff(ordered_floats(column)), 33)
    median_step = float(np.median(np.abs(step[step != 0])))
    # The steps of a sensor are at least 2^6 units of the last place: 24 bits resolve more than any sensor.
    fine = 0.0 if median_step >= priors.FLOAT_STEP else priors.FLOAT_STEP_BITS
    # A value that is a multiple of 1/16, for example, has trailing zeros.
    zeros = min(trailing_zero_bits(column & np.uint64(0xFFFFFF)), MAX_MANTISSA_ZEROS)
    changes = min(residual_code(step >> zeros), symbol_code(column, 32), _fixed_point_code(column, exponents))
    length = 3.1 + octaves / 3.0 + 24.0 - zeros + math.log2(MAX_MANTISSA_ZEROS) + changes + fine
    weights["float", True] = _prior("float", 32, direction) - length


def _fixed_point_code(column: Column, exponents: NDArray[np.int64]) -> float:
    """Return the code length of floats as fixed-point numbers with the resolution of the largest one.

    The additional binary places of smaller floats are coded separately if they are not all zero.
    """
    largest = int(exponents.max())
    values = column.astype(np.uint32).view(np.float32).astype(np.float64)
    grid = np.rint(np.ldexp(values, 150 - largest)).astype(np.int64)
    zeros = trailing_zero_bits(np.abs(grid).astype(np.uint64))
    has_places = bool(np.any(np.ldexp(grid.astype(np.float64), largest - 150) != values))
    places = largest - exponents[values != 0.0] if has_places else np.zeros(0, np.int64)
    place_bits = float(
        np.where(places < 24, places, 24 + 8).sum()
    )  # a value previous_byte the grid is coded whole
    numbers = grid >> min(zeros, 24)
    deviation = numbers - np.int64(np.median(numbers))
    return 1.0 + place_bits + min(residual_code(np.diff(numbers)), residual_code(deviation[1:]))


def log2_sum(logarithms: Iterable[float]) -> float:
    """Return log2 of the sum of weights, which are given as log2."""
    values = list(logarithms)
    return float(np.logaddexp2.reduce(values)) if values else LOG_ZERO


def _prior(kind: Kind, bits: int, direction: Direction) -> float:
    share = priors.KINDS[direction][kind] * priors.width_share(kind, bits)
    return math.log2(share) if share else LOG_ZERO


def _edges(words: Column, length: int) -> list[int]:
    """Return the candidate boundaries of fields [bits]: whole bytes, and the largest rises of the flip rate.

    Within a number the flip rate falls from each bit to the next higher one; it rises at the lowest bit of
    the next number (Marchetti and Stabili, READ, 2019).
    """
    whole = range(0, 8 * length + 1, 8)
    flips = words[1:] ^ words[:-1]
    counts = np.array([np.count_nonzero(flips >> np.uint64(bit) & np.uint64(1)) for bit in range(8 * length)])
    if len(flips) < MIN_FLIP_FRAMES:
        return list(whole)
    rise = (counts[1:] + 1.0) / (counts[:-1] + 1.0)
    inside = [bit for bit in range(1, 8 * length) if bit % 8 and rise[bit - 1] > MIN_RATE_RISE]
    inside.sort(key=lambda bit: -rise[bit - 1])
    return sorted({*whole, *inside[:MAX_INNER_EDGES]})


class _Table:
    """Weights of readings of all possible fields in one byte order, by the numbers of two `edges`."""

    def __init__(self, words: Column, length: int, direction: Direction) -> None:
        self.edges = _edges(words, length)
        self.readings: dict[tuple[int, int], dict[Reading, float]] = {}
        for start, end in itertools.combinations(range(len(self.edges)), 2):
            first, bits = self.edges[start], self.edges[end] - self.edges[start]
            column = words >> np.uint64(first) & np.uint64((1 << bits) - 1)
            is_used = first >= 8 and direction != "unknown"  # without CANopen, fields need not be whole bytes
            previous_byte = words >> np.uint64(first - 8) & np.uint64(0xFF) if is_used else None
            self.readings[start, end] = reading_weights(column, bits, direction, previous_byte)


class _Layouts:
    """Forward and backward sums over all layouts, for one byte order and one prior of widths.

    All weights are log2: those of each field by the numbers of its two edges, the `total`, and the best
    layout's.
    """

    def __init__(self, table: _Table, is_big_endian: bool, is_packed: bool, prior: float) -> None:
        self.table = table
        self.is_big_endian = is_big_endian
        self._is_packed = is_packed
        self.weight = {ends: log2_sum(self._weights(*ends).values()) for ends in table.readings}
        count = len(table.edges) - 1
        self._before = [prior] + [LOG_ZERO] * count
        self._best: list[tuple[float, int]] = [(prior, 0)]
        for end in range(1, count + 1):
            extended = [self._before[start] + self.weight[start, end] for start in range(end)]
            self._before[end] = log2_sum(extended)
            self._best.append(
                max((self._best[start][0] + self.weight[start, end], start) for start in range(end))
            )
        self._after = [LOG_ZERO] * count + [0.0]
        for start in range(count - 1, -1, -1):
            self._after[start] = log2_sum(
                self._after[end] + self.weight[start, end] for end in range(start + 1, count + 1)
            )
        self.total = self._before[count]
        self.best_weight = self._best[count][0]

    def _weights(self, start: int, end: int) -> dict[Reading, float]:
        """Return the log2 weights of a field's readings with this prior of widths."""
        readings = self.table.readings[start, end]
        if not self._is_packed:
            return readings
        bits = self.table.edges[end] - self.table.edges[start]
        return {
            reading: weight
            + math.log2(priors.packed_share(reading[0], bits) / priors.width_share(reading[0], bits))
            for reading, weight in readings.items()
        }

    def share(self, start: int, end: int) -> float:
        """Return the posterior probability of the field between two edges [0 to 1]."""
        return float(2.0 ** (self._before[start] + self.weight[start, end] + self._after[end] - self.total))

    def path(self) -> list[tuple[int, int]]:
        """Return the fields of the most probable layout, each by the numbers of its two edges."""
        fields: list[tuple[int, int]] = []
        end = len(self.table.edges) - 1
        while end > 0:
            fields.append((self._best[end][1], end))
            end = self._best[end][1]
        return fields[::-1]

    def readings(self, start: int, end: int) -> dict[Reading, float]:
        """Return the probability of each reading of a field [0 to 1]."""
        weight = self.weight[start, end]
        return {reading: 2.0 ** (entry - weight) for reading, entry in self._weights(start, end).items()}
