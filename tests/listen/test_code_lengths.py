"""Code lengths: what the shorter description is."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.listen.code_lengths import (
    first_value,
    flags_value,
    number_code,
    ordered_floats,
    residual_code,
    symbol_code,
    to_signed,
    trailing_zero_bits,
)

RANDOM = np.random.default_rng(3)


def column(values):
    return np.asarray(values, np.int64).astype(np.uint64)


@given(st.lists(st.integers(0, 2**16 - 1), min_size=1), st.integers(1, 64))
def test_centred_values_are_the_same_modulo_the_ring_and_lie_around_zero(values, bits):
    found = to_signed(column(values), bits)
    assert all((int(a) - b) % 2**bits == 0 for a, b in zip(found, values, strict=True))
    assert all(-(2 ** (bits - 1)) <= int(a) < 2 ** (bits - 1) for a in found)


@pytest.mark.parametrize("scale", [0.7, 5.0, 400.0, 60000.0])
def test_normal_noise_takes_a_tenth_of_a_bit_more_than_its_entropy_at_most(scale):
    noise = np.rint(RANDOM.normal(0, scale, 6000)).astype(np.int64)
    counts = np.unique(noise, return_counts=True)[1]
    entropy = max(
        0.5 * math.log2(2 * math.pi * math.e * scale**2),
        -float((counts / 6000) @ np.log2(counts / 6000)) if scale < 50 else 0.0,
    )
    assert entropy - 0.02 < residual_code(noise) / 6000 < entropy + 0.1


def test_a_counter_is_described_the_same_wherever_it_wraps():
    steps = RANDOM.integers(-40, 60, 3000).cumsum()
    lengths = [number_code(column((steps + start) % 2**16), 16).steps for start in (0, 30000, 65000)]
    assert max(lengths) - min(lengths) < 60.0


def test_a_counter_that_starts_again_before_its_bits_are_full_says_where():
    assert number_code(column(np.arange(0, 90000, 37) % 3600), 32).counter_range == 3600
    assert number_code(column(np.arange(0, 90000, 37) % 4096), 32).counter_range == 4096
    assert number_code(column(np.arange(0, 90000, 37) % 65536), 16).counter_range == 0


def test_one_number_of_two_bytes_is_shorter_than_its_bytes_and_two_numbers_are_shorter_alone():
    walk = RANDOM.integers(-30, 31, 4000).cumsum() + 20000
    low, high = column(walk & 0xFF), column(walk >> 8)
    together = number_code(column(walk), 16).steps
    apart = number_code(low, 8).steps + number_code(high, 8).steps
    assert together < apart - 100
    one, other = (RANDOM.integers(-1, 2, 4000).cumsum() % 256 for _ in range(2))
    assert number_code(column(one), 8).steps + number_code(column(other), 8).steps < (
        number_code(column(one + 256 * other), 16).steps - 100
    )


def test_flags_that_toggle_are_shorter_as_flags_than_as_a_number():
    flags = column(
        np.where(np.arange(3000) // 100 % 2, 0x4000, 0) + np.where(np.arange(3000) // 170 % 2, 1, 0)
    )
    assert symbol_code(flags, 16) < number_code(flags, 16).steps


@given(st.lists(st.floats(width=32, allow_nan=False, allow_infinity=False), min_size=2))
def test_ordered_floats_have_the_order_of_their_values(values):
    bits = np.array(values, np.float32).view(np.uint32).astype(np.uint64)
    order = ordered_floats(bits).astype(np.int64)
    for a, b, x, y in zip(values, values[1:], order, order[1:], strict=False):
        assert (a < b) == (x < y) or a == b


@given(st.integers(-(2**31), 2**31), st.sampled_from([8, 16, 32, 64]))
def test_a_first_value_takes_its_bits_and_those_that_say_how_many(value, bits):
    assert first_value(value, bits) <= math.log2(bits + 1) + abs(value).bit_length()


def test_a_converter_that_is_left_justified_is_as_short_as_its_upper_bits():
    walk = RANDOM.integers(-9, 10, 3000).cumsum() + 1000
    justified, plain = number_code(column(walk * 16), 16), number_code(column(walk), 12)
    assert justified.steps == pytest.approx(plain.steps, abs=8.0)


@given(st.lists(st.integers(0, 2**20), min_size=1), st.integers(0, 20))
def test_the_lowest_zeros_of_a_column_are_those_of_all_its_values(values, zeros):
    shifted = column([value << zeros for value in values])
    count = trailing_zero_bits(shifted)
    assert count >= zeros
    assert count == 64 or np.any(shifted >> np.uint64(count) & np.uint64(1))


def test_flags_that_change_with_the_byte_before_them_are_shorter_where_it_is_known():
    before, flags = np.zeros(3000, np.uint64), np.zeros(3000, np.uint64)
    for moment in (100, 700, 1900, 2500):
        before[moment:] ^= np.uint64(3)
        flags[moment:] ^= np.uint64(1)
    assert symbol_code(flags, 8, before) < symbol_code(flags, 8) - 20.0


def test_no_flag_and_few_flags_are_told_shortly_and_any_number_of_them_in_some_bits_more():
    assert flags_value(0, 16) < 2.0
    assert flags_value(0xFFFF, 16) < 2.0 + math.log2(17)
