"""vehicle.toml: what is written comes back, and every impossible robot is refused by name."""

from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.vehicle.errors import VehicleFileError
from omnimate.vehicle.file import format_vehicle, load_vehicle, parse_vehicle, save_vehicle
from omnimate.vehicle.parameters import (
    Bus,
    Drive,
    Encoder,
    Limits,
    Linkage,
    ParameterError,
    Truck,
    VehicleParameters,
)
from tests.samples import broken

trucks = st.builds(
    Truck,
    wheelbase=st.floats(0.01, 10),
    wheel_diameter_left=st.floats(0.005, 3),
    wheel_diameter_right=st.floats(0.005, 3),
)


@st.composite
def wheels(draw, channel, node):
    bits = draw(st.sampled_from([16, 24, 32, 64]))
    return Encoder(
        channel=channel,
        node=node,
        cob_id=0x180 + node,
        start_bit=draw(st.integers(0, 64 - bits)),
        bits=bits,
        signed=draw(st.booleans()),
        sign=draw(st.sampled_from([1, -1])),
        counts_per_turn=draw(st.one_of(st.integers(1, 10**9), st.floats(1, 1e9))),
        range=draw(st.one_of(st.none(), st.integers(2, 2**bits))),
        profile=draw(st.sampled_from(["cia406", "cia402"])),
        serial=draw(st.one_of(st.none(), st.integers(0, 2**32 - 1))),
    )


singles = st.builds(
    lambda name, truck, bus, left, right, limits, drives: VehicleParameters(
        name, {"a": truck}, None, bus, (left, right), drives, limits
    ),
    st.text(max_size=20),
    trucks,
    st.builds(Bus, st.sampled_from([125_000, 500_000]), st.floats(0.001, 1)),
    wheels("a.left", 1),
    wheels("a.right", 2),
    st.builds(Limits, st.floats(0.001, 20), st.floats(0.001, 50)),
    st.sampled_from([(), (Drive("a.left", 11, 0x20B, -1, 4096.0),)]),
)


@given(singles)
def test_what_is_written_comes_back(vehicle):
    assert parse_vehicle(format_vehicle(vehicle)) == vehicle


def test_a_two_truck_robot_is_read_and_survives_a_round_trip_on_disk(robot_toml, tmp_path):
    vehicle = parse_vehicle(robot_toml)
    save_vehicle(vehicle, tmp_path / "vehicle.toml")
    assert load_vehicle(tmp_path / "vehicle.toml") == vehicle
    assert [path.name for path in tmp_path.iterdir()] == ["vehicle.toml"]
    assert vehicle.linkage == Linkage(1.0)
    assert vehicle.channels[6] == "link"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [pytest.param(*case.values(), id=case["message"]) for case in broken("vehicle/broken_vehicles.toml")],
)
def test_an_impossible_robot_is_refused_by_file_key_and_expectation(robot_toml, old, new, message):
    assert old in robot_toml
    with pytest.raises(VehicleFileError) as caught:
        parse_vehicle(robot_toml.replace(old, new, 1), "shop/vehicle.toml")
    assert str(caught.value) == message
    assert message.startswith(f"shop/vehicle.toml: {caught.value.key}: ")


def test_no_toml_and_no_file_are_said(tmp_path):
    with pytest.raises(VehicleFileError, match="not TOML"):
        parse_vehicle("= 3")
    with pytest.raises(VehicleFileError, match="cannot be read"):
        load_vehicle(tmp_path / "absent.toml")


@given(st.dictionaries(st.text(max_size=8), st.integers() | st.booleans() | st.text(max_size=5), max_size=4))
def test_any_other_table_is_refused_and_never_crashes(table):
    text = "\n".join(
        f"{key!r} = {str(value).lower() if isinstance(value, bool) else value!r}"
        for key, value in table.items()
    )
    with pytest.raises(VehicleFileError):
        parse_vehicle(text)


@pytest.mark.parametrize(
    ("text", "place"),
    [("6063h", (0x6063, 0)), ("6020h:2", (0x6020, 2)), ("0x2041:0A", (0x2041, 10)), ("6c64", (0x6C64, 0))],
)
def test_an_encoder_names_its_object(robot_toml, text, place):
    named = robot_toml.replace('channel = "a.left"', f'channel = "a.left"\nobject = "{text}"', 1)
    vehicle = parse_vehicle(named)
    assert vehicle.encoders[0].position_object == place
    assert vehicle.encoders[1].position_object is None
    assert parse_vehicle(format_vehicle(vehicle)) == vehicle


def test_an_eds_is_found_from_the_folder_of_the_file_wherever_the_robot_is_saved(robot_toml, tmp_path):
    here, there = tmp_path / "robot", tmp_path / "runs" / "1"
    there.mkdir(parents=True)
    here.mkdir()
    named = robot_toml.replace('channel = "a.left"', 'channel = "a.left"\neds = "../eds/wheel.eds"', 1)
    (here / "vehicle.toml").write_text(named)
    vehicle = load_vehicle(here / "vehicle.toml")
    (path,) = vehicle.eds_files.values()
    assert Path(path).resolve() == tmp_path / "eds" / "wheel.eds"
    save_vehicle(vehicle, there / "vehicle.toml")
    assert 'eds = "../../eds/wheel.eds"' in (there / "vehicle.toml").read_text()
    (path,) = load_vehicle(there / "vehicle.toml").eds_files.values()
    assert Path(path).resolve() == tmp_path / "eds" / "wheel.eds"


def test_a_node_has_one_eds(robot_toml):
    vehicle = parse_vehicle(robot_toml)
    first, second, *others = vehicle.encoders
    with pytest.raises(ParameterError, match=r"both b\.eds and a\.eds for node"):
        replace(
            vehicle,
            encoders=(
                replace(first, eds="b.eds"),
                replace(second, node=first.node, eds="a.eds"),
                *others,
            ),
        )
