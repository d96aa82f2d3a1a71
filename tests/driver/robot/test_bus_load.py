from dataclasses import replace

import pytest

from omnimate.driver.errors import BusOverload
from omnimate.driver.robot.bus_load import check_load, forecast_load, frame_bits
from omnimate.vehicle.assembly import pdo_lengths
from omnimate.vehicle.parameters import Bus


@pytest.mark.parametrize(
    ("bitrate", "most", "least"),
    [(125_000, 1126, 926), (250_000, 2252, 1852), (500_000, 4505, 3704), (1_000_000, 9009, 7407)],
)
def test_frames_per_second_are_those_of_the_wire(bitrate, most, least):
    """Frames of 8 bytes, unstuffed and at worst."""
    assert round(bitrate / frame_bits(8, stuffed=False)) == most
    assert round(bitrate / frame_bits(8, stuffed=True)) == least


def test_seven_full_pdos_at_100_hz_use_16_to_20_percent(kit):
    """Without the heartbeats, which add less than a percent."""
    vehicle = kit.two_trucks()
    wide = tuple(replace(encoder, start_bit=32) for encoder in vehicle.encoders)
    load = forecast_load(replace(vehicle, encoders=wide))
    assert 0.16 < load.least < 0.17
    assert 0.195 < load.worst < 0.21
    assert not load.is_high


def test_four_drives_add_15_to_17_percent_of_500_kbit_s(kit):
    """Their commands at 100 Hz, heartbeats every 25 ms, and status words by SDO every 30 ms."""
    vehicle = kit.two_trucks()
    drives = tuple(kit.drive(wheel, 17 + number) for number, wheel in enumerate(vehicle.wheels))
    added = forecast_load(replace(vehicle, drives=drives)).worst - forecast_load(vehicle).worst
    assert 0.15 < added < 0.17


def test_above_60_percent_it_warns_and_above_80_it_refuses(kit):
    vehicle = kit.two_trucks()
    warned = forecast_load(replace(vehicle, bus=Bus(125_000, 0.009)))
    assert warned.is_high
    assert "late" in warned.in_words()
    check_load(warned)
    refused = forecast_load(replace(vehicle, bus=Bus(125_000, 0.005)))
    with pytest.raises(BusOverload, match="sync_period") as caught:
        check_load(refused)
    assert caught.value.load > 0.8


def test_a_pdo_is_as_long_as_its_last_field(kit):
    fields = (
        kit.wheel_encoder("a.left", 1, cob_id=0x181, bits=24),
        kit.wheel_encoder("a.right", 1, cob_id=0x181, start_bit=32, bits=20),
    )
    assert pdo_lengths(kit.one_truck(fields)) == {0x181: 7}
