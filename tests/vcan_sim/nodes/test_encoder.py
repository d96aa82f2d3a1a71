"""CiA 406 encoders: position, preset, code sequence, scaling, and what they report of themselves."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.vcan_sim.errors import SimulationError
from omnimate.vcan_sim.nodes.encoder import Latch, Sensor
from omnimate.vcan_sim.reference import reference_single, reference_vehicle

WHEEL = reference_vehicle().encoder("a.left")
JOINT = reference_vehicle().encoder("joint_a")


def test_the_position_is_what_the_plant_counts_in_twos_complement(bench):
    bench.plant.counts = (-3, 4, 0, 0, 8192, 8000, 5000)
    bench.sync()
    assert [bench.read(node, 0x6004) for node in (1, 2, 5, 6, 7)] == [2**32 - 3, 4, 8192, 8000, 5000]


def test_all_positions_are_of_the_same_sync(bench):
    bench.plant.counts = (1,) * 7
    assert bench.read(1, 0x6004) == 0
    bench.sync()
    assert {bench.read(node, 0x6004) for node in range(1, 8)} == {1}


def test_encoders_tell_range_and_resolution_of_the_vehicles_file(bench):
    assert [bench.read(1, index) for index in (0x6001, 0x6002, 0x6501)] == [40000, 0, 40000]
    assert [bench.read(5, index) for index in (0x6001, 0x6002, 0x6501, 0x6502)] == [16384, 16384, 16384, 1]
    assert bench.read(7, 0x6501) == 100_000  # [nm]


def test_device_types_are_of_profile_406(bench):
    types = [bench.read(node, 0x1000) for node in (1, 5, 7)]
    assert types == [0x0002_0196, 0x0001_0196, 0x0008_0196]


def test_serial_numbers_differ_and_stand_in_both_places(bench):
    serials = {bench.read(node, 0x1018, 4) for node in range(1, 8)}
    assert len(serials) == 7
    assert bench.read(3, 0x1018, 4) == bench.read(3, 0x650B)


def test_the_identity_of_the_vehicles_file_is_shown(make_bench):
    vehicle = reference_single()
    named = replace(vehicle.encoders[0], vendor=0x1234, product=0x5678, serial=99)
    bench = make_bench(replace(vehicle, encoders=(named, vehicle.encoders[1])))
    assert [bench.read(1, 0x1018, sub) for sub in (1, 2, 4)] == [0x1234, 0x5678, 99]
    assert bench.read(2, 0x1018, 1) != 0x1234


def test_the_object_of_the_vehicles_file_is_a_position_too(make_bench):
    vehicle = reference_single()
    named = replace(vehicle.encoders[0], object="2041h:2")
    bench = make_bench(replace(vehicle, encoders=(named, vehicle.encoders[1])))
    bench.plant.counts = (-3, 4)
    bench.sync()
    assert bench.read(1, 0x2041, 2) == 2**32 - 3


def test_a_preset_makes_the_position_its_value_and_shows_in_6509h(bench):
    bench.sync(count=1000)
    bench.write(1, 0x6003, 0, 250, 4)
    assert bench.read(1, 0x6004) == 250
    assert bench.read(1, 0x6509) == 2**32 - 750
    bench.sync(count=1010)
    assert bench.read(1, 0x6004) == 260


def test_the_code_sequence_turns_the_direction_round(bench):
    bench.write(1, 0x6000, 0, 1, 2)
    bench.sync(count=100)
    assert bench.read(1, 0x6004) == 2**32 - 100
    assert bench.read(1, 0x6500) == 1


def test_scaling_counts_in_6001h_units_per_turn(bench):
    bench.write(1, 0x6001, 0, 400, 4)
    bench.sync(count=20_000)
    assert bench.read(1, 0x6004) == 20_000  # not before bit 2 of 6000h
    bench.write(1, 0x6000, 0, 4, 2)
    assert bench.read(1, 0x6004) == 200


def test_the_speed_is_of_the_last_sync_period_and_saturates(bench):
    bench.sync(count=3)
    assert bench.read(1, 0x6030, 1) == 200
    bench.sync(count=3 - 10_000)
    assert bench.read(1, 0x6030, 1) == 0x8000


def test_6200h_and_the_event_timer_of_tpdo1_are_one(bench):
    bench.write(1, 0x6200, 0, 55, 2)
    assert bench.read(1, 0x1800, 5) == 55
    bench.write(1, 0x1800, 5, 77, 2)
    assert bench.read(1, 0x6200) == 77


def test_a_wheels_counter_starts_from_0_after_a_reset_but_a_joint_knows_its_angle(bench):
    bench.plant.counts = (123,) * 4 + (9000, 9000, 5000)
    bench.sync()
    assert bench.read(1, 0x6004) == 123
    bench.nmt(0x81)
    assert bench.read(1, 0x6004) == 0
    assert bench.read(1, 0x6509) == 0  # it has not been preset
    assert bench.read(5, 0x6004) == 9000
    assert bench.read(7, 0x6004) == 5000


@given(
    counts=st.lists(st.integers(-(2**31), 2**31 - 1), min_size=1, max_size=20),
    start=st.integers(-(2**31), 2**31 - 1),
)
def test_after_a_restart_differences_are_those_of_the_plant(counts, start):
    latch = Latch((start,), 0.015)
    sensor = Sensor(latch, 0, WHEEL)
    sensor.restart()
    assert sensor.position() == 0
    for count in counts:
        latch.take((count,))
        assert (sensor.position() - (count - start)) % 2**32 == 0
        assert -(2**31) <= sensor.position() < 2**31


@given(count=st.integers(0, 16383), preset=st.integers(0, 16383), later=st.integers(0, 16383))
def test_an_unsigned_position_stays_within_its_range_whatever_the_preset(count, preset, later):
    latch = Latch((count,), 0.015)
    sensor = Sensor(latch, 0, JOINT)
    sensor.preset(preset)
    assert sensor.position() == preset
    latch.take((later,))
    assert sensor.position() == (preset + later - count) % 16384


def two_channels_on_one_node(**changes):
    vehicle = reference_single()
    left = replace(vehicle.encoders[0], **changes)
    right = replace(vehicle.encoders[1], node=1, cob_id=0x181, start_bit=32, **changes)
    return replace(vehicle, encoders=(left, right))


def test_an_encoder_with_two_sensors_has_them_at_6020h_in_the_order_of_their_bits(make_bench):
    bench = make_bench(two_channels_on_one_node())
    bench.plant.counts = (11, -22)
    bench.sync()
    assert [bench.read(1, 0x6020, sub) for sub in (1, 2)] == [11, 2**32 - 22]
    bench.write(1, 0x6010, 2, 5, 4)
    assert bench.read(1, 0x6020, 2) == 5
    assert bench.aborts(1, 0x6010, 3, 5, 4) == 0x06090011


def test_a_node_that_no_device_could_be_is_refused(make_bench):
    wide = replace(WHEEL, bits=64)
    vehicle = reference_vehicle()
    with pytest.raises(SimulationError, match="64 bits"):
        make_bench(replace(vehicle, encoders=(wide, *vehicle.encoders[1:])))
    mixed = replace(vehicle.drives[0], node=1)
    with pytest.raises(SimulationError, match="node 1"):
        make_bench(replace(vehicle, drives=(mixed, *vehicle.drives[1:])))
