"""Readings: no travel is lost or counted twice, whatever is missing, live as over a recording."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.ipec.errors import NoLinkageError
from omnimate.ipec.readings import Reading, SampleReader, scales_of, sense, table_of
from omnimate.vcan_sim.reference import reference_single
from omnimate.vehicle.compiled import compiled, record
from omnimate.vehicle.parameters import CHANNELS, WHEELS
from omnimate.vehicle.recording import Recording
from omnimate.vehicle.sample import Sample

NAN = (math.nan,) * 7


@compiled
def take(scales, readings, counts, present):
    sense(scales[0], readings[0], counts, present)


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
        take(scales, reading, row, read)
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
        take(scales, reading, row, read)
        for truck in range(2):
            if not read[2 * truck : 2 * truck + 2].all():
                assert not reading["moved"][0, truck]
                assert not reading["travel"][0, 2 * truck : 2 * truck + 2].any()
        assert bool(reading["linked"][0]) == bool(read[4:].all())


def test_the_linkage_reads_zero_angles_and_its_length_at_rest_at_its_zero_counts(robot):
    scales, reading = scales_of(robot), record(Reading)
    take(scales, reading, scales["zero"][0], np.ones(7, bool))
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
    table, reads = table_of(recording)
    reader = SampleReader(vehicle)
    for index in range(3):
        sample = Sample(index, 0.0, tuple(counts[index].tolist()), tuple(present[index].tolist()), NAN, NAN)
        live = reader.read(sample)
        assert np.array_equal(live[0], table[index])
        assert np.array_equal(live[1], reads[index])
    for column, channel in enumerate(CHANNELS):
        assert np.array_equal(table[:, column], recording.channel_counts(channel))


def test_a_count_of_a_wheel_is_as_far_as_the_vehicle_says(robot):
    scales = scales_of(robot)["scale"][0]
    assert scales[:4].tolist() == [robot.metres_per_count(wheel) for wheel in WHEELS]


def test_a_robot_with_one_truck_is_refused_everywhere():
    single = reference_single()
    recording = Recording(single, np.arange(2.0), np.zeros((2, 2), np.int64), np.ones((2, 2), bool))
    for refuse in (lambda: scales_of(single), lambda: SampleReader(single), lambda: table_of(recording)):
        with pytest.raises(NoLinkageError):
            refuse()
