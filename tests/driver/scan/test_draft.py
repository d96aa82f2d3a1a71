"""The drafted vehicle.toml: with its comments answered, it is the robot that was scanned."""

import re

import pytest

from docs.generate.conformance import BenchBus, Simulated
from omnimate.driver.canopen.pdo_mapping import Entry
from omnimate.driver.canopen.pdo_parameters import RPDO, TPDO, PdoSetting
from omnimate.driver.scan.draft import draft_vehicle, positions_of
from omnimate.driver.scan.node import NodeReading
from omnimate.driver.scan.scan import Scan, scan
from omnimate.driver.scan.traffic import BusTraffic
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vehicle.errors import VehicleFileError
from omnimate.vehicle.file import parse_vehicle

URL = "socketcan://can0"
WHEELS = ("a.left", "a.right", "b.left", "b.right")


def pdo(base, cob_id, *entries, kind=1):
    return PdoSetting(base, cob_id, kind, None, None, tuple(Entry(*entry) for entry in entries))


def draft(*nodes, heard=None, bitrate=None, eds=()):
    return draft_vehicle(Scan(nodes, heard or BusTraffic()), URL, bitrate, dict(eds))


def answered(text, answers):
    """Uncomment every key, with these values for its occurrences in turn, else with the example's."""
    left = {key: list(values) for key, values in answers.items()}

    def line(match):
        key, example = match[1], match[2]
        return f"{key} = {left[key].pop(0)}" if left.get(key) else f"{key} = {example}"

    return re.sub(r"^# (\w+) = (\S+).*$", line, text, flags=re.MULTILINE)


def encoder(number, device_type=0x00020196, objects=(), **fields):
    return NodeReading(
        number,
        device_type,
        objects=dict(objects),
        tpdos=(pdo(TPDO, 0x180 + number, (0x6004, 0, 32)),),
        **fields,
    )


def test_the_draft_of_the_simulated_robot_answered_is_that_robot(monkeypatch):
    bus = BenchBus(Simulated)
    monkeypatch.setattr("omnimate.driver.scan.scan.time.monotonic", lambda: bus.time)
    robot = reference_vehicle()
    text = draft_vehicle(scan(bus, URL, timeout=0.02, wait=0.0), URL, 500_000, {})
    drafted = parse_vehicle(
        answered(
            text,
            {
                "channel": [f'"{name}"' for name in (*WHEELS, "joint_a", "joint_b")],
                "wheel": [f'"{name}"' for name in WHEELS],
                "sign": [str(owner.sign) for owner in (*robot.encoders, *robot.drives)],
                "zero": [str(robot.encoder(name).zero) for name in ("joint_a", "joint_b", "link")],
            },
        )
    )
    assert drafted.trucks == robot.trucks
    assert drafted.bus == robot.bus
    for was, own in zip(drafted.encoders, robot.encoders, strict=True):
        assert (was.channel, was.node, was.sign, was.zero, was.scale) == (
            *(own.channel, own.node, own.sign, own.zero, own.scale),
        )
    for was, own in zip(drafted.drives, robot.drives, strict=True):
        assert (was.wheel, was.node, was.sign, was.counts_per_turn) == (
            *(own.wheel, own.node, own.sign, own.counts_per_turn),
        )


def test_a_draft_is_toml_and_names_what_is_missing_first():
    with pytest.raises(VehicleFileError, match=r"truck\.a\.wheelbase: missing"):
        parse_vehicle(draft(encoder(1), encoder(2)))


def test_a_robot_with_two_wheels_has_one_truck():
    text = draft(encoder(1), encoder(2))
    assert "[truck.b]" not in text
    assert "[linkage]" not in text
    drafted = parse_vehicle(answered(text, {"channel": ['"a.left"', '"a.right"']}))
    assert [encoder.cob_id for encoder in drafted.encoders] == [0x181, 0x182]


def test_a_position_stands_where_the_mapping_has_it_in_the_pdo_that_answers_sync():
    node = NodeReading(
        5,
        0x00020192,
        tpdos=(
            pdo(TPDO, 0x80000185, (0x6064, 0, 32)),
            pdo(TPDO + 1, 0x285, (0x6064, 0, 32), kind=255),
            pdo(TPDO + 2, 0x385, (0x6041, 0, 16), (0x6061, 0, 8), (0x6064, 0, 32)),
        ),
    )
    (position,) = positions_of(node)
    assert (position.cob_id, position.start_bit, position.bits) == (0x385, 24, 32)


def test_a_vendors_position_is_named_and_one_of_two_is_enough():
    internal = NodeReading(5, None, tpdos=(pdo(TPDO, 0x185, (0x6063, 0, 32)),))
    assert 'object = "6063h"' in draft(internal)
    both = NodeReading(5, None, tpdos=(pdo(TPDO, 0x185, (0x6063, 0, 32), (0x6064, 0, 32)),))
    assert [position.index for position in positions_of(both)] == [0x6064]


def test_each_sensor_of_an_encoder_is_an_encoder():
    node = NodeReading(5, 0x000A0196, tpdos=(pdo(TPDO, 0x185, (0x6020, 1, 32), (0x6020, 2, 32)),))
    text = draft(node)
    assert 'object = "6020h:1"' in text
    assert 'object = "6020h:2"' in text
    assert text.count("cob_id = 0x185") == 2


def test_an_encoder_without_a_mapping_gets_a_pdo_that_the_driver_maps():
    text = draft(NodeReading(5, 0x00020196, tpdos=(pdo(TPDO, 0x80000185), pdo(TPDO + 1, 0x80000285))))
    assert re.search(r"cob_id = 0x285 +# the driver will map it", text)


def test_a_pdo_with_29_bits_is_drafted_with_the_predefined_cob_id_that_the_driver_will_set():
    """Its lower 11 bits are no identifier of the bus, nor may `vehicle.toml` have one of 29 bits."""
    encoder = NodeReading(5, 0x00020196, tpdos=(pdo(TPDO + 1, 0x38FF01A0, (0x6004, 0, 32)),))
    drive = NodeReading(6, 0x00020192, rpdos=(pdo(RPDO, 0x38FF01A0, (0x60FF, 0, 32)),))
    text = draft(encoder, drive)
    assert re.search(r"cob_id = 0x285 +# the driver will map it", text)
    assert re.search(r"cob_id = 0x206 +# the driver will map it", text)


def test_the_velocity_pdo_of_a_drive_is_used_and_its_gear():
    objects = {(0x608F, 1): 4096, (0x608F, 2): 1, (0x6091, 1): 49, (0x6091, 2): 2}
    drive = NodeReading(
        5,
        0x00020192,
        rpdos=(pdo(RPDO, 0x205, (0x6040, 0, 16)), pdo(RPDO + 2, 0x405, (0x6040, 0, 16), (0x60FF, 0, 32))),
        objects=objects,
    )
    text = draft(drive)
    assert "cob_id = 0x405" in text
    assert text.count("counts_per_turn = 100352 ") == 2  # of the drive, and of its encoder


def test_what_was_heard_and_stated_is_written():
    heard = BusTraffic()
    heard.syncs.extend([0.0, 0.01, 0.02])
    text = draft(encoder(1, vendor=0x2F, serial=7), heard=heard, bitrate=250_000, eds={1: 'a "b".eds'})
    for line in (
        "sync_period = 0.01 ",
        "bitrate = 250000",
        "vendor = 0x2F",
        "serial = 0x7",
        r'eds = "a \"b\".eds"',
    ):
        assert f"\n{line}" in text
    assert "product" not in text


def test_a_bus_without_encoders_says_what_to_do():
    assert "no encoder was found: switch all devices on" in draft()
