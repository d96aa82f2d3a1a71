"""`omnimate dbc`: other tools decode the values that this project reads."""

import re
from dataclasses import replace

import cantools
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.files.logs.assemble import assemble
from omnimate.files.logs.dbc import dbc_of_vehicle
from omnimate.files.logs.frames import Frame, frames_of
from omnimate.files.logs.recording_to_frames import encode
from omnimate.vehicle.file import load_vehicle, parse_vehicle
from omnimate.vehicle.parameters import Drive
from omnimate.vehicle.se2 import wrap

TABLE = (
    ("a.left", 22, 0x296, 0, 32, 1, "counts_per_turn = 40000"),
    ("a.right", 22, 0x296, 32, 32, -1, "counts_per_turn = 40000"),
    ("b.left", 3, 0x183, 5, 24, 1, "counts_per_turn = 20000"),
    ("b.right", 4, 0x184, 0, 24, -1, "counts_per_turn = 20000"),
    ("joint_a", 5, 0x185, 0, 16, 1, "counts_per_turn = 16384\nzero = 3000"),
    ("joint_b", 6, 0x186, 0, 16, -1, "counts_per_turn = 16384\nzero = -20"),
    ("link", 7, 0x187, 0, 32, -1, "counts_per_metre = 20000\nzero = 77"),
)


@pytest.fixture(scope="module")
def vehicle(robot_toml):
    """A robot with a quote in its name, whose PDOs have every kind of field, and two drives."""
    head = robot_toml[: robot_toml.index("[[encoder]]")].replace("omnimate-7", 'rob\\"ot')
    encoders = [
        f'[[encoder]]\nchannel = "{channel}"\nnode = {node}\ncob_id = {cob_id}\nstart_bit = {start}\n'
        f"bits = {bits}\nsigned = true\nsign = {sign}\n{scale}\n"
        for channel, node, cob_id, start, bits, sign, scale in TABLE
    ]
    drives = (Drive("a.left", 11, 0x20B, 1, 40000.0), Drive("b.right", 14, 0x20E, -1, 20000.0, start_bit=16))
    return replace(parse_vehicle(head + "\n".join(encoders)), drives=drives)


counts = st.integers(-(2**14), 2**14)


@given(rows=st.lists(st.tuples(*[counts] * 7), min_size=1, max_size=3))
def test_cantools_decodes_the_values_that_the_assembler_reads(vehicle, rows):
    database = cantools.database.load_string(dbc_of_vehicle(vehicle), "dbc")
    for row in rows:
        raw = dict(zip(vehicle.channels, row, strict=True))
        frames, decoded = [Frame(0.0, 0x080)], {}
        for cob_id in dict.fromkeys(encoder.cob_id for encoder in vehicle.encoders):
            message = database.get_message_by_frame_id(cob_id)
            encoders = [encoder for encoder in vehicle.encoders if encoder.cob_id == cob_id]
            word = sum(int(encode(np.array([raw[e.channel]]), e)[0]) for e in encoders)
            data = word.to_bytes(message.length, "little")
            frames.append(Frame(0.0, cob_id, data))
            decoded |= message.decode(data)
        recording = assemble(frames_of(frames), vehicle).recording
        for wheel in vehicle.wheels:
            assert decoded[wheel.replace(".", "_")] == pytest.approx(
                recording.wheel_angle(wheel)[0], abs=1e-9
            )
        for joint in ("joint_a", "joint_b"):
            assert float(wrap(decoded[joint] - recording.joint_angle(joint)[0])) == pytest.approx(
                0.0, abs=1e-9
            )
        assert decoded["link"] == pytest.approx(recording.link_length()[0], abs=1e-12)


def test_units_and_names_are_those_of_the_vehicle(vehicle):
    database = cantools.database.load_string(dbc_of_vehicle(vehicle), "dbc")
    message = database.get_message_by_name("a_left_a_right")
    assert message.frame_id == 0x296
    assert [(signal.name, signal.unit) for signal in message.signals] == [
        ("a_left", "rad"),
        ("a_right", "rad"),
    ]
    assert database.get_message_by_name("link").signals[0].unit == "m"


def test_heartbeats_emergencies_and_commands_are_decoded_too(vehicle):
    database = cantools.database.load_string(dbc_of_vehicle(vehicle), "dbc")
    assert database.decode_message(0x716, b"\x05") == {"state": "operational"}
    assert database.decode_message(0x096, bytes.fromhex("1081010000000000")) == {
        "error_code": 0x8110,
        "error_register": 1,
    }
    speed = database.decode_message(0x20E, b"\x0f\0" + (-20000).to_bytes(4, "little", signed=True))
    assert speed["target_b_right"] == pytest.approx(2 * np.pi)


def test_every_name_is_a_c_identifier_of_at_most_32_characters(vehicle):
    names = re.findall(r"^(?:BO_ \d+| SG_) (\S+)", dbc_of_vehicle(vehicle), re.MULTILINE)
    assert len(names) > 20
    assert all(re.fullmatch(r"[A-Za-z_]\w{0,31}", name.rstrip(":")) for name in names)


def test_a_pdo_with_many_channels_is_named_by_its_cob_id(robot_toml):
    text = robot_toml
    for node in range(1, 8):
        start = 8 * (node - 1)
        text = text.replace(
            f"cob_id = {0x180 + node}\nstart_bit = 0\nbits = 32",
            f"cob_id = 400\nstart_bit = {start}\nbits = 8",
        )
    database = cantools.database.load_string(dbc_of_vehicle(parse_vehicle(text)), "dbc")
    assert len(database.get_message_by_name("TPDO_190").signals) == 7


def test_the_verb_writes_the_file(omnimate, tmp_path, robot_toml):
    (tmp_path / "vehicle.toml").write_text(robot_toml)
    assert omnimate("dbc", tmp_path / "vehicle.toml", tmp_path / "out.dbc").code == 0
    assert len(cantools.database.load_file(tmp_path / "out.dbc").messages) == 1 + 7 + 2 * 7


def test_vehicles_of_foreign_recordings_have_a_dbc(shared_data):
    for path in sorted((shared_data / "concealed").glob("*/*/vehicle.toml")):
        vehicle = load_vehicle(path)
        database = cantools.database.load_string(dbc_of_vehicle(vehicle), "dbc")
        signals = {signal.name for message in database.messages for signal in message.signals}
        assert {channel.replace(".", "_") for channel in vehicle.channels} <= signals
