"""Logs of every format: all that can be read is read, and what cannot is said."""

import gzip
import io

import can
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.files.logs.blocks import read_log
from omnimate.files.logs.formats.block_reader import BlockReader
from omnimate.files.logs.formats.candump_blocks import BlockParser
from omnimate.files.logs.formats.candump_lines import format_lines, parse_line
from omnimate.files.logs.frames import ERROR, EXTENDED, REMOTE, SENT, concatenate, frames_of
from omnimate.vehicle.errors import LogError
from tests.files.logs.any_frames import CLASSICAL, any_frames
from tests.samples import CANOPEN_TRACES, CAR_LOG, OTHER_ROBOT, OTHER_ROBOT_ASC, cases

GOOD = b"".join(
    b"(17000000%02d.000250) can0 18%d#00%02X\n" % (index, index % 8, index) for index in range(60)
)


def read(tmp_path, content, name="can.log"):
    """Read a file with this content."""
    path = tmp_path / name
    path.write_bytes(content)
    return read_log(path)


@pytest.mark.parametrize("pack", [bytes, gzip.compress], ids=["plain", "gzipped"])
def test_a_byte_order_mark_costs_no_frame(tmp_path, pack):
    log = read(tmp_path, pack(b"\xef\xbb\xbf" + GOOD))
    assert (len(log.frames), log.blocks.left_out) == (60, 0)


@pytest.mark.parametrize("end", [b"\n", b"\r\n", b""])
def test_lines_that_explain_an_error_frame_are_no_lost_frames(tmp_path, end):
    """`candump -e` prints them below it."""
    line = b" (1700000000.000250)  can0  200000A8   [8]  00 00 80 19 00 00 60 00   ERRORFRAME\n"
    words = b"\tprotocol-violation{{}{acknowledge-slot}}\n\tbus-error\n\terror-counter-tx-rx{{96}{0}}"
    log = read(tmp_path, line + words + end)
    assert (len(log.frames), log.blocks.left_out, log.blocks.truncated) == (1, 0, False)


times = st.integers(10**15, 4 * 10**15).map(lambda micros: micros / 1e6)
frames = any_frames(CLASSICAL, error_directions=(0, SENT), times=times)
logs = st.lists(frames, min_size=1, max_size=60)


def screen(times):
    """A log as candump prints it on the screen, with these times."""
    return b"".join(b" (%010.6f)  can0  181   [2]  00 01\n" % time for time in times)


steps = st.lists(st.integers(1, 3_000_000), min_size=3, max_size=40)


@given(steps=steps.filter(lambda steps: np.mean(np.diff(steps) > 0) < 0.8))
def test_times_since_the_last_frame_are_added_up(tmp_path_factory, steps):
    """`candump -td`; the same frames as `candump -tz` have the same times."""
    path = tmp_path_factory.mktemp("log")
    passed = np.cumsum([0, *steps]) / 1e6
    since_start = read(path, screen(passed))
    assert since_start.frames.time == pytest.approx(passed, abs=1e-7)
    since_last = read(path, screen([0.0, *np.array(steps) / 1e6]))
    assert since_last.frames.time == pytest.approx(passed, abs=1e-6)
    assert "candump -td" in next(since_last.blocks.problems())
    assert since_last.blocks.is_whole


@given(rows=logs, dlc=st.sampled_from(["[{}] ", "{} ", ""]), between=st.sampled_from([" ", ""]))
def test_the_plain_form_of_other_recorders_is_read(rows, dlc, between):
    """`time interface id [dlc] bytes`."""
    for row in rows:
        if row.flags & (REMOTE | ERROR):
            continue
        identifier = f"{row.can_id:08X}" if row.flags & EXTENDED else f"{row.can_id:03X}"
        length, data = dlc.format(len(row.data)), between.join(f"{byte:02x}" for byte in row.data)
        line = f"{row.time:.6f} {row.channel} {identifier} {length}{data}"
        assert parse_line(line.encode()) == row._replace(flags=row.flags & EXTENDED)


@pytest.mark.parametrize(
    "line", [b"1.5 can0 181 [3] 01 02", b"1.5 can0 181 " + b" 01" * 9, b"(1.5) can0 181"]
)
def test_a_plain_line_that_is_no_frame_is_told(line):
    assert isinstance(parse_line(line), str)


@given(rows=logs, at=st.lists(st.integers(0, 59), max_size=6), form=st.sampled_from(["log", "ta"]))
def test_garbage_costs_its_own_line_and_no_other(rows, at, form):
    lines = [f"{line}\n".encode() for line in format_lines(frames_of(rows), form)]
    places = sorted({min(place, len(lines)) for place in at}, reverse=True)
    for place in places:
        lines.insert(place, b"(170x0000.0) can0 18z#0\n")
    parser = BlockParser()
    assert list(parser.parse(b"".join(lines))) == rows
    assert len(parser.skipped) == len(places)
    for skipped in parser.skipped:
        assert lines[skipped.line - 1].startswith(b"(170x")


@given(st.lists(st.binary(max_size=40).filter(lambda text: b"\n" not in text), max_size=40))
def test_no_file_at_all_breaks_the_reader(lines):
    parser = BlockParser()
    found = parser.parse(b"".join(line + b"\n" for line in lines) or b"\n")
    assert len(found) + len(parser.skipped) <= max(len(lines), 1)


def test_many_equal_lines_are_read_at_once_with_every_kind_of_odd_line_among_them(tmp_path):
    odd = [
        b"(1700000000.0) can0 181#00\n",
        b"(1700000000.000250) can1 181#00FF\n",
        b"\n",
        b"(1700000000.000250) can0 181#00gg\n",
    ]
    result = read(tmp_path, GOOD + b"".join(odd) + GOOD)
    assert len(result.frames) == 122
    assert [(skipped.line, skipped.text) for skipped in result.blocks.skipped] == [
        (64, "(1700000000.000250) can0 181#00gg")
    ]
    assert result.frames.channels == ("can0", "can1")
    assert not result.blocks.truncated


def test_windows_line_ends_and_lower_case_digits_are_read(tmp_path):
    result = read(tmp_path, GOOD.replace(b"\n", b"\r\n").lower())
    assert len(result.frames) == 60
    assert result.blocks.is_whole


def test_blocks_are_joined_wherever_they_are_cut(tmp_path):
    path = tmp_path / "can.log"
    path.write_bytes(GOOD)
    for size in (1, 7, 38, 1000):
        parser = BlockParser()
        blocks = [parser.parse(block) for block in BlockReader(path, size).lines() if block]
        assert list(concatenate(blocks)) == list(read_log(path).frames)


def test_a_last_line_without_its_newline_counts_if_it_looks_complete(tmp_path):
    result = read(tmp_path, GOOD.rstrip())
    assert len(result.frames) == 60
    assert result.blocks.is_whole


@pytest.mark.parametrize("cut", range(2, 34))
def test_a_log_that_was_cut_off_is_read_up_to_there_and_says_so(tmp_path, cut):
    result = read(tmp_path, GOOD[:-cut])
    assert len(result.frames) == 59
    assert result.blocks.truncated
    assert result.blocks.skipped[0].line == 60
    assert "cut off" in next(result.blocks.problems())


@pytest.mark.parametrize(
    "content", [b"", b"hello\nworld\n", b"  can0  181   [2]  00 10\n", bytes(range(256)) * 40]
)
def test_a_file_without_any_frame_is_an_error_that_names_the_line(tmp_path, content):
    with pytest.raises(LogError, match="no CAN frame") as caught:
        read(tmp_path, content)
    assert caught.value.line == 1


def test_a_missing_file_is_an_error(tmp_path):
    with pytest.raises(LogError, match="cannot be read"):
        read_log(tmp_path / "none.log")


def test_gzip_is_known_by_its_content_and_may_have_several_members(tmp_path):
    result = read(tmp_path, gzip.compress(GOOD) + gzip.compress(GOOD), "can.log")
    assert len(result.frames) == 120
    assert result.blocks.is_whole


def test_a_gzip_file_that_ends_early_or_is_damaged_gives_what_it_still_holds(tmp_path):
    content = "".join(
        f"(1700000000.{index:06d}) can0 181#{index * 7919 % 65536:04X}\n" for index in range(50000)
    ).encode()
    packed = gzip.compress(content)
    half = read(tmp_path, packed[: len(packed) // 2])
    assert 10000 < len(half.frames) < 50000
    assert half.blocks.truncated
    broken = read(tmp_path, packed[:-8] + bytes(8))
    assert len(broken.frames) > 49000
    assert broken.blocks.truncated


def test_a_log_of_too_many_interfaces_is_marked(tmp_path):
    lines = b"".join(b"(1700000000.000250) can%d 181#00\n" % index for index in range(300))
    result = read(tmp_path, lines)
    assert len(result.frames) == 256
    assert "interfaces" in result.blocks.skipped[0].reason


MESSAGES = [
    can.Message(
        timestamp=1.0, arbitration_id=0x181, is_extended_id=False, data=b"\x01\x02", channel=0, is_rx=True
    ),
    can.Message(
        timestamp=1.5, arbitration_id=0x12345, is_extended_id=True, data=bytes(8), channel=0, is_rx=True
    ),
    can.Message(timestamp=2.0, arbitration_id=0x80, is_extended_id=False, data=b"", channel=0, is_rx=True),
]
EXPECTED = [(0x181, b"\x01\x02", 0), (0x12345, bytes(8), EXTENDED), (0x080, b"", 0)]


def content_of(writer, suffix, tmp_path, messages=MESSAGES):
    """What python-can writes in a format."""
    path = tmp_path / f"written{suffix}"
    with writer(path) as log:
        for message in messages:
            log(message)
    return path.read_bytes()


@pytest.mark.parametrize(
    ("writer", "suffix"), [(can.ASCWriter, ".asc"), (can.BLFWriter, ".blf"), (can.TRCWriter, ".trc")]
)
@pytest.mark.parametrize("packed", [False, True])
def test_foreign_formats_are_read_whatever_their_suffix(tmp_path, writer, suffix, packed):
    content = content_of(writer, suffix, tmp_path)
    result = read(tmp_path, gzip.compress(content) if packed else content, "some.file")
    assert [(frame.can_id, frame.data, frame.flags) for frame in result.frames] == EXPECTED
    assert np.diff(result.frames.time).tolist() == pytest.approx([0.5, 0.5], abs=2e-3)
    assert result.blocks.is_whole


TRC = b""";$FILEVERSION=1.1
;$STARTTIME=44964.5725134375
;
     1)       144.5  Rx         0728  1  7F
     2)       145.5  Rx         0728  x  7F
     3)       146.5  Warng      FFFFFFFF  4  00 00 00 08  BUSLIGHT
     4)       147.5  Rx         070A  1  RTR
     5)       148.5  Rx         0181  8  00 11
"""


def test_a_bad_line_of_a_peak_trace_is_marked_and_the_rest_is_read(tmp_path):
    result = read(tmp_path, TRC)
    assert [(frame.can_id, frame.flags, frame.length) for frame in result.frames] == [
        (0x728, 0, 1),
        (0x70A, REMOTE, 1),
    ]
    assert [skipped.line for skipped in result.blocks.skipped] == [5, 8]


PEAK_2 = b""";$FILEVERSION=2.1
;$STARTTIME=45364.369224537
;$COLUMNS=N,O,T,B,I,d,R,L,D
;
      1     16310.827 DT 1      0770 Rx -  1    05
      2     16695.357 RR 3      070A Rx -  1
"""


def test_peak_traces_of_version_2_name_their_buses(tmp_path):
    result = read(tmp_path, PEAK_2)
    assert [(frame.can_id, frame.channel) for frame in result.frames] == [(0x770, "can1"), (0x70A, "can3")]
    assert result.blocks.is_whole


def test_a_truncated_blf_gives_what_it_still_holds_or_an_error(tmp_path):
    content = content_of(can.BLFWriter, ".blf", tmp_path)
    assert read(tmp_path, content).blocks.is_whole
    assert read(tmp_path, content[:-2]).blocks.truncated
    with pytest.raises(LogError, match="ends before the first"):
        read(tmp_path, content[: len(content) // 2])


def test_fd_frames_of_foreign_logs_are_marked(tmp_path):
    fd = can.Message(
        timestamp=1.2, arbitration_id=0x181, is_extended_id=False, data=bytes(12), is_fd=True, channel=0
    )
    result = read(tmp_path, content_of(can.ASCWriter, ".asc", tmp_path, [*MESSAGES, fd]))
    assert len(result.frames) == 3
    assert "CAN FD" in result.blocks.skipped[0].reason


MINIMON = b"""ASCII Trace IXXAT MiniMon V3  Version: 1.0.0.1271\r
Date: 28.01.2025\r
Start time: 10:47:15\r
Baudrate: 500 kbit/s\r
"Time";"Identifier (hex)";"Format";"Flags";"Data (hex)"\r
"00:02:20.69";"703";"Std";"";"7F "\r
"00:02:30.72";"702";"Std";"Rtr ";"Remote request  DLC = 1 "\r
"00:02:30.73";"18FF0001";"Ext";"";""\r
"00:02:30.74";"FFF";"Std";"";""\r
garbage\r
"""


def test_minimon_traces_are_read_on_their_own_clock(tmp_path):
    result = read(tmp_path, MINIMON)
    assert [(f.can_id, f.data, f.flags, f.length) for f in result.frames] == [
        (0x703, b"\x7f", 0, 1),
        (0x702, b"", REMOTE, 1),
        (0x18FF0001, b"", EXTENDED, 0),
    ]
    assert result.frames.time[0] == pytest.approx(1738061235 + 140.69)
    assert [skipped.line for skipped in result.blocks.skipped] == [9, 10]


@pytest.mark.parametrize(
    ("path", "count"),
    cases(
        (OTHER_ROBOT, 300),
        (OTHER_ROBOT_ASC, 300),
        *zip(CANOPEN_TRACES, (781, 11283), strict=True),
        (CAR_LOG, 53800),
    ),
)
def test_logs_are_read_to_the_last_frame(path, count):
    log = read_log(path)
    assert log.blocks.is_whole
    assert len(log.frames) == count


@pytest.mark.parametrize("path", cases(OTHER_ROBOT, CAR_LOG))
def test_a_candump_log_is_what_python_can_reads(path):
    with (gzip.open if path.suffix == ".gz" else open)(path, "rt") as file:
        text = file.read()
    ours = read_log(path)
    theirs = list(can.CanutilsLogReader(io.StringIO(text)))
    assert [(f.time, f.can_id, f.data) for f in ours.frames] == [
        (m.timestamp, m.arbitration_id, bytes(m.data)) for m in theirs
    ]
    assert "".join(line + "\n" for line in format_lines(ours.frames, "log", ours.blocks.stamp_width)) == text
