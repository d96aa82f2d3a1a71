"""Readings: no travel is lost or counted twice, whatever is missing, live as over a recording."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.ipec.readings import Reading, columns_of, convert_counts, ordered_counts, read_sample, scales_of
from omnimate.vehicle.compiled import record
from omnimate.vehicle.parameters import CHANNELS
from omnimate.vehicle.recording import Recording
from omnimate.vehicle.sample import Sample

NAN = (math.nan,) * 7


@st.composite
def samples(draw):
    """Draw counts `(N, 7)` and presence `(N, 7)`."""
    count = draw(st.integers(1, 12))
    chance = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    return chance.integers(-1000, 1000, (count, 7)), chance.random((count, 7)) < 0.7


@given(samples())
def test_the_travel_of_a_truck_adds_up_to_the_way_between_its_first_and_last_reading(robot, drawn):
    counts, present = drawn
    scales, reading = scales_of(robot), record(Reading)
    total = np.zeros(4)
    for row, read in zip(counts, present, strict=True):
        convert_counts(scales[0], reading[0], row, read)
        total += reading["travel"][0]
    for truck in range(2):
        wheels = slice(2 * truck, 2 * truck + 2)
        both = np.flatnonzero(present[:, wheels].all(axis=1))
        expected = np.zeros(2)
        if len(both):
            expected = (counts[both[-1], wheels] - counts[both[0], wheels]) * scales["scale"][0, wheels]
        assert total[wheels] == pytest.approx(expected, abs=1e-9)


@given(samples())
def test_a_truck_moves_only_where_both_of_its_wheels_are_present(robot, drawn):
    scales, reading = scales_of(robot), record(Reading)
    for row, read in zip(*drawn, strict=True):
        convert_counts(scales[0], reading[0], row, read)
        for truck in range(2):
            if not read[2 * truck : 2 * truck + 2].all():
                assert not reading["moved"][0, truck]
                assert not reading["travel"][0, 2 * truck : 2 * truck + 2].any()
        assert bool(reading["linked"][0]) == bool(read[4:].all())


def test_the_linkage_reads_zero_angles_and_its_length_at_rest_at_its_zero_counts(robot):
    scales, reading = scales_of(robot), record(Reading)
    convert_counts(scales[0], reading[0], scales["zero"][0], np.ones(7, bool))
    assert reading["joint"][0].tolist() == [0.0, 0.0]
    assert reading["length"][0] == robot.linkage.length


@given(st.permutations(range(7)), st.integers(0, 2**32 - 1))
def test_the_order_of_channels_in_vehicle_toml_changes_nothing_live_or_over_a_recording(robot, order, seed):
    chance = np.random.default_rng(seed)
    vehicle = type(robot)(
        robot.name, robot.trucks, robot.linkage, robot.bus, tuple(robot.encoders[k] for k in order)
    )
    counts, present = chance.integers(-1000, 1000, (3, 7)), chance.random((3, 7)) < 0.7
    recording = Recording(vehicle, np.arange(3.0), counts, present)
    table, reads = ordered_counts(recording)
    columns = columns_of(vehicle, CHANNELS)
    for index in range(3):
        sample = Sample(index, 0.0, tuple(counts[index].tolist()), tuple(present[index].tolist()), NAN, NAN)
        live = read_sample(sample, columns)
        assert np.array_equal(live[0], table[index])
        assert np.array_equal(live[1], reads[index])
    for column, channel in enumerate(CHANNELS):
        assert np.array_equal(table[:, column], recording.channel_counts(channel))
