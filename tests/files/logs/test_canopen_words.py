"""CANopen frames in words."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.files.logs.canopen_words import (
    describe_frame,
    emcy_in_words,
    error_register_in_words,
    sdo_abort_in_words,
)


@pytest.mark.parametrize(
    ("can_id", "data", "words"),
    [
        (0x000, "0103", "NMT start, node 3"),
        (0x000, "8200", "NMT reset communication, all nodes"),
        (0x080, "", "SYNC"),
        (0x083, "2081000628000000", "EMCY of node 3: 8120h CAN in error passive mode, error register 00h"),
        (0x083, "", "EMCY of node 3, empty"),
        (0x100, "2954990331000000", "TIME"),
        (0x181, "00", "TPDO1 of node 1"),
        (0x57F, "", "RPDO4 of node 127"),
        (0x583, "430010002D010000", "SDO from node 3: answer 1000h:00 = 0000012Dh"),
        (0x583, "6016100100000000", "SDO from node 3: confirmed 1016h:01"),
        (0x603, "2316100188130100", "SDO to node 3: download 1016h:01 = 00011388h"),
        (0x603, "4000100000000000", "SDO to node 3: upload 1000h:00"),
        (0x603, "6000000000000000", "SDO to node 3: upload segment"),
        (
            0x589,
            "8008100000000206",
            "SDO from node 9: abort of 1008h:00, 06020000h object does not exist in the object dictionary",
        ),
        (0x603, "C600200064000000", "SDO to node 3: block download 2000h:00"),
        (0x603, "C200200064000000", "SDO to node 3: block download 2000h:00"),
        (0x583, "A40020007F000000", "SDO from node 3: block download 2000h:00"),
        (0x603, "C500000000000000", "SDO to node 3: block segment"),
        (0x603, "A40020007F000000", "SDO to node 3: block upload 2000h:00"),
        (0x583, "C600200064000000", "SDO from node 3: block upload 2000h:00"),
        (0x583, "C200200064000000", "SDO from node 3: block upload 2000h:00"),
        (0x603, "A300000000000000", "SDO to node 3: block segment"),
        (0x603, "00", "SDO to node 3: wrong length 1"),
        (0x703, "00", "heartbeat of node 3: boot-up"),
        (0x70A, "85", "heartbeat of node 10: operational"),
        (0x70A, "33", "heartbeat of node 10: unknown state 33h"),
        (0x7E5, "0400000000000000", "LSS command"),
    ],
)
def test_frames_of_the_predefined_connection_set_are_said_in_words(can_id, data, words):
    assert describe_frame(can_id, bytes.fromhex(data)) == words


@pytest.mark.parametrize(
    ("can_id", "data"), [(0x10A, "00"), (0x001, ""), (0x180, "00"), (0x703, "0000"), (0x7FF, "")]
)
def test_what_is_not_canopen_is_not_described(can_id, data):
    assert describe_frame(can_id, bytes.fromhex(data)) is None


def test_a_remote_heartbeat_is_node_guarding():
    assert describe_frame(0x70A, b"", remote=True) == "node guarding request to node 10"


def test_emergency_codes_fall_back_to_their_class():
    assert emcy_in_words(0x8130) == "life guard or heartbeat error"
    assert emcy_in_words(0x5530) == "device hardware"
    assert emcy_in_words(0x8199) == "communication"
    assert emcy_in_words(0xABCD) == "unknown error code"


def test_every_abort_code_that_drivers_meet_has_words():
    for code in (
        0x05040000,
        0x06010002,
        0x06020000,
        0x06040041,
        0x06040042,
        0x06070010,
        0x06090011,
        0x06090030,
        0x08000022,
    ):
        assert sdo_abort_in_words(code) != "unknown abort code"
    assert sdo_abort_in_words(0x12345678) == "unknown abort code"


@given(st.integers(0, 0x7FF), st.binary(max_size=8), st.booleans())
def test_no_frame_at_all_breaks_the_description(can_id, data, remote):
    describe_frame(can_id, data, remote=remote)


def test_the_error_register_names_the_errors_of_its_bits():
    assert error_register_in_words(0x00) == "no error"
    assert error_register_in_words(0x91) == "generic, communication, manufacturer specific"
