"""Layouts: boundaries, byte order, kind and sign from data alone."""

import numpy as np
import pytest

from omnimate.listen.layout import find_layout
from omnimate.listen.signals import SURE_PROBABILITY

RANDOM = np.random.default_rng(7)
N = 3000
TIME = np.arange(N) * 0.02
SMOOTH = 900.0 * np.sin(TIME / 3.0) + 400.0 * np.sin(TIME / 1.1)


def packed(*fields, order="little"):
    """Return the data of frames whose fields are columns of numbers with their bytes."""
    rows = []
    for values in zip(*(column for column, _ in fields), strict=True):
        parts = [
            (int(value) % 2 ** (8 * size)).to_bytes(size, order)
            for value, (_, size) in zip(values, fields, strict=True)
        ]
        rows.append(b"".join(parts))
    return np.frombuffer(b"".join(rows), np.uint8).reshape(N, -1)


def found(data, **options):
    layout = find_layout(data, **options)
    return [
        (each.start, each.bits, *max(each.readings, key=lambda reading: each.readings[reading]))
        for each in layout.fields
    ], layout


def noisy(values, noise=0.8):
    return np.rint(values + RANDOM.normal(0, noise, N)).astype(np.int64)


def test_a_position_and_a_speed_are_separated_at_their_boundary():
    position = np.cumsum(noisy(SMOOTH / 20)) + 5_000_000
    fields, layout = found(packed((position, 4), (noisy(SMOOTH), 2)), direction="sent")
    assert [field[:3] for field in fields] == [(0, 32, "number"), (32, 16, "number")]
    assert fields[1][3] is True
    assert all(each.probability > SURE_PROBABILITY for each in layout.fields)


def test_two_fields_of_24_bits_are_found_because_the_data_say_so():
    fields, _ = found(packed((np.cumsum(noisy(SMOOTH / 5)), 3), (np.cumsum(noisy(-SMOOTH / 5)), 3)))
    assert [field[:2] for field in fields] == [(0, 24), (24, 24)]


def test_the_status_word_of_a_drive_is_recognised_by_its_states():
    status = np.select([TIME < 5, TIME < 5.1, TIME < 5.2], [0x0250, 0x0231, 0x0233], 0x0237)
    status = status | np.where(np.floor(TIME / 7) % 2 > 0, 0x0400, 0)
    fields, layout = found(packed((status, 2), (noisy(SMOOTH * 50), 4)), direction="sent")
    assert fields[0] == (0, 16, "status word", None)
    assert layout.fields[0].probability > SURE_PROBABILITY


def test_the_control_word_is_recognised_where_a_device_receives_it():
    control = np.select([TIME < 5, TIME < 5.1, TIME < 5.2], [0, 6, 7], 0x0F)
    fields, _ = found(packed((control, 2), (noisy(SMOOTH * 50), 4)), direction="received")
    assert fields[0] == (0, 16, "control word", None)


def test_a_big_endian_number_is_found_where_little_endian_is_not_a_rule():
    data = packed((noisy(SMOOTH + 9000), 2), (noisy(SMOOTH * 7), 2), order="big")
    _, layout = found(data, big_endian_prior=0.5)
    assert layout.big_endian_probability > SURE_PROBABILITY
    assert [(each.start, each.bits) for each in layout.fields] == [(0, 16), (16, 16)]


def test_a_float_is_distinguished_from_an_integer():
    value = (24.5 + 3.0 * np.sin(TIME / 9) + RANDOM.normal(0, 0.05, N)).astype("<f4")
    data = np.concatenate((value.view(np.uint8).reshape(N, 4), packed((noisy(SMOOTH * 99), 4))), axis=1)
    fields, _ = found(data, direction="sent")
    assert fields == [(0, 32, "float", True), (32, 32, "number", True)]


def test_what_never_changes_leaves_its_parts_open():
    _, layout = found(packed((np.zeros(N), 4), (noisy(SMOOTH), 2)))
    assert all(set(each.readings) == {("constant", None)} for each in layout.fields[:-1])
    assert layout.fields[0].probability < SURE_PROBABILITY


def test_a_few_frames_leave_nothing_certain():
    layout = find_layout(packed((noisy(SMOOTH) + 5000, 4), (noisy(SMOOTH) + 5000, 4))[:3])
    assert all(
        each.probability < SURE_PROBABILITY or max(each.readings.values()) < SURE_PROBABILITY
        for each in layout.fields
    )


@pytest.mark.parametrize("shift", [0, 20000, 60000])
def test_where_a_counter_wraps_does_not_move_its_boundaries(shift):
    counter = (np.cumsum(noisy(np.abs(SMOOTH) / 9)) + shift) % 2**16
    fields, _ = found(packed((counter, 2), (noisy(SMOOTH), 2)))
    assert [field[:2] for field in fields] == [(0, 16), (16, 16)]


def test_fields_that_are_no_whole_bytes_are_found_where_the_data_say_so():
    columns = [np.cumsum(noisy(factor * SMOOTH / 5)) for factor in (1.0, -0.9)]
    third = np.cumsum(noisy(SMOOTH / 90)) + 20000
    words = (columns[0] % 2**20) | (columns[1] % 2**20) << 20 | third << 40
    data = np.ascontiguousarray(words.astype("<u8")).view(np.uint8).reshape(N, 8)
    fields, layout = found(data)
    assert [field[:2] for field in fields[:2]] == [(0, 20), (20, 20)]
    assert fields[2][0] == 40
    assert layout.fields[0].probability > SURE_PROBABILITY


def test_a_counter_in_a_byte_beside_constant_bytes_is_no_wider_number():
    count = np.arange(N) + 178
    constants = (np.full(N, 10), 1), (count % 256, 1), (np.full(N, 0x490000), 3)
    fields, _ = found(packed(*constants), direction="received")
    assert (8, 8) in [field[:2] for field in fields]


def test_a_drive_that_is_switched_on_is_known_by_four_frames():
    data = np.array([[0x00, 0], [0x06, 0], [0x07, 0], [0x0F, 0]], np.uint8)
    fields, _ = found(data, direction="received")
    assert fields == [(0, 16, "control word", None)]
    data = np.array([[0x40, 2], [0x31, 2], [0x33, 2], [0x37, 2]], np.uint8)
    fields, _ = found(data, direction="sent")
    assert fields == [(0, 16, "status word", None)]


def test_the_status_word_of_a_drive_that_is_enabled_all_the_time_is_recognised():
    fields, _ = found(packed((np.full(N, 0x0237), 2), (noisy(SMOOTH * 50), 4)), direction="sent")
    assert fields[0] == (0, 16, "status word", None)


def test_a_float_of_a_sensor_with_a_coarse_step_is_a_float():
    values = (np.rint((24.5 + SMOOTH / 900.0) * 16) / 16).astype(np.float32)
    data = values.astype("<f4").view(np.uint8).reshape(N, 4)
    fields, _ = found(data, direction="sent")
    assert fields == [(0, 32, "float", True)]


def test_noise_about_0_is_a_float_although_some_of_its_values_are_tiny():
    values = (0.3 * RANDOM.normal(0, 1, N)).astype("<f4")
    fields, _ = found(values.view(np.uint8).reshape(N, 4), direction="sent")
    assert fields == [(0, 32, "float", True)]
