"""The line formats of candump, byte for byte."""

from datetime import datetime

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.files.logs.formats.candump_lines import format_frame, format_lines, parse_line
from omnimate.files.logs.frames import ERROR, EXTENDED, RECEIVED, REMOTE, SENT, Frame, frames_of
from tests.files.logs.any_frames import ANY_TIMES, CLASSICAL, any_frames

PRINTED = [
    (
        Frame(1700000000.00025, 0x181, bytes.fromhex("0010000000200000")),
        "(1700000000.000250) can0 181#0010000000200000",
    ),
    (Frame(1700000000.0, 0x080), "(1700000000.000000) can0 080#"),
    (Frame(12.5, 0x12345, b"\xab", EXTENDED, None, "can1"), "(0000000012.500000) can1 00012345#AB"),
    (Frame(1.0, 0x701, b"", REMOTE), "(0000000001.000000) can0 701#R"),
    (Frame(1.0, 0x701, b"", REMOTE, 8), "(0000000001.000000) can0 701#R8"),
    (Frame(1.0, 0x88, bytes(8), ERROR), "(0000000001.000000) can0 20000088#0000000000000000"),
    (Frame(1.0, 0x181, b"\x01", RECEIVED), "(0000000001.000000) can0 181#01 R"),
    (Frame(1.0, 0x181, b"\x01", SENT), "(0000000001.000000) can0 181#01 T"),
]
PRINTED_LONG = [
    (
        Frame(1700000000.00025, 0x181, bytes.fromhex("0010000000200000")),
        " (1700000000.000250)  can0  181   [8]  00 10 00 00 00 20 00 00",
    ),
    (Frame(1700000000.0, 0x080), " (1700000000.000000)  can0  080   [0] "),
    (Frame(1.0, 0x12345, b"\xab", EXTENDED), " (0000000001.000000)  can0  00012345   [1]  AB"),
    (Frame(1.0, 0x701, b"", REMOTE, 1), " (0000000001.000000)  can0  701   [1]  remote request"),
    (
        Frame(1.0, 0x88, bytes(8), ERROR),
        " (0000000001.000000)  can0  20000088   [8]  00 00 00 00 00 00 00 00   ERRORFRAME",
    ),
    (Frame(1.0, 0x181, b"\x01", SENT), " (0000000001.000000)  can0  TX - -  181   [1]  01"),
]

DIRECTIONS = (0, RECEIVED, SENT)
frames = any_frames(CLASSICAL, ("can0", "vcan12"), DIRECTIONS, DIRECTIONS, ANY_TIMES)


@pytest.mark.parametrize(
    ("form", "frame", "line"),
    [*(("log", *row) for row in PRINTED), *(("ta", *row) for row in PRINTED_LONG)],
)
def test_a_form_is_what_candump_prints(form, frame, line):
    """`candump -L` and `candump -ta`."""
    assert format_frame(frame, form) == line


@pytest.mark.parametrize("form", ["log", "ta"])
@given(frame=frames)
def test_a_printed_frame_is_read_again_as_the_same_frame(form, frame):
    assert parse_line(format_frame(frame, form).encode()) == frame


def test_interfaces_are_right_aligned_where_there_are_several():
    lines = list(format_lines(frames_of([Frame(1.0, 1), Frame(1.0, 1, channel="vcan12")])))
    assert lines == ["(0000000001.000000)   can0 001#", "(0000000001.000000) vcan12 001#"]


def test_the_long_form_indents_short_identifiers_once_a_long_one_was_seen():
    lines = list(format_lines(frames_of([Frame(1.0, 1), Frame(1.0, 1, b"", EXTENDED), Frame(1.0, 1)]), "ta"))
    assert [line.split("can0")[1] for line in lines] == [
        "  001   [0] ",
        "  00000001   [0] ",
        "       001   [0] ",
    ]


def test_the_ascii_column_and_a_missing_leading_space_are_read():
    line = b"(1.000000)  can0       181   [2]  41 42                     'AB'"
    assert parse_line(line) == Frame(1.0, 0x181, b"AB", 0, 2)


def test_a_date_is_read_in_the_time_zone_of_this_computer():
    time = datetime(2026, 11, 28, 10, 13, 43, 566726).timestamp()  # noqa: DTZ001 -- local, as candump prints it
    line = b" (2026-11-28 10:13:43.566726)  can0  181   [2]  41 42"
    assert parse_line(line) == Frame(time, 0x181, b"AB", 0, 2)


def test_dots_between_bytes_and_a_raw_length_code_are_read():
    assert parse_line(b"(1.0) can0 181#11.22") == Frame(1.0, 0x181, b"\x11\x22", 0, 2)
    assert parse_line(b"(1.0) can0 181#1122334455667788_E").length == 8


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        (b" (2026-13-28 10:13:43.566726)  can0  181   [0] ", "expected `(seconds) interface ID#DATA`"),
        (b"(1.0) can0  181  [12]  00 00 00 00 00 00 00 00 00 00 00 00", "CAN FD"),
        (b"(1.0) can0 800#00", "not an identifier"),
        (b"(1.0) can0 FFFFFFFF#00", "not an identifier"),
        (b"  can0  181   [2]  00 10", "no time"),
        (b"can0 181#00", "no time"),
        (b"DROPCOUNT: dropped 5 CAN frames on 'can0' socket (total drops 5)", "dropped frames"),
    ],
)
def test_a_line_without_a_frame_that_can_be_read_says_why(line, reason):
    """More of them, word for word, stand in `tests/data/logs/broken_candump_lines.toml`."""
    assert reason in parse_line(line)


@given(st.binary(max_size=60))
def test_no_line_at_all_breaks_the_parser(line):
    parse_line(line)
