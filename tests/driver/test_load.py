from __future__ import annotations

from dataclasses import replace

import pytest

from driver.errors import BusOverload
from driver.load import check, forecast, frame_bits, pdo_lengths
from vehicle.parameters import Bus


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
    wide = tuple(replace(one, start_bit=32) for one in vehicle.encoders)
    load = forecast(replace(vehicle, encoders=wide), heartbeat=1e9)
    assert 0.16 < load.least < 0.17
    assert 0.195 < load.worst < 0.205
    assert not load.is_high


def test_above_60_percent_it_warns_and_above_80_it_refuses(kit):
    vehicle = kit.two_trucks()
    warned = forecast(replace(vehicle, bus=Bus(125_000, 0.009)), 0.5)
    assert warned.is_high
    assert "late" in warned.in_words()
    check(warned)
    refused = forecast(replace(vehicle, bus=Bus(125_000, 0.005)), 0.5)
    with pytest.raises(BusOverload, match="sync_period") as caught:
        check(refused)
    assert caught.value.load > 0.8


def test_a_pdo_is_as_long_as_its_last_field(kit):
    fields = (
        kit.wheel_encoder("a.left", 1, cob_id=0x181, bits=24),
        kit.wheel_encoder("a.right", 1, cob_id=0x181, start_bit=32, bits=20),
    )
    assert pdo_lengths(kit.one_truck(fields)) == {0x181: 7}
