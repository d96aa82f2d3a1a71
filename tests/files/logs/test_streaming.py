"""Logs frame by frame: what is written in a format is read again, in bounded memory, by us and by others."""

import bz2
import gc
import lzma
import sys
import tracemalloc
import types

import can
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omnimate.files.logs import blocks as module
from omnimate.files.logs.blocks import LogStream, read_log
from omnimate.files.logs.formats.block_reader import BlockReader
from omnimate.files.logs.formats.python_can_logs import message_of_frame
from omnimate.files.logs.frames import ERROR, FD, REMOTE, SENT, Frame
from omnimate.files.logs.writing import SUFFIXES, log_suffix, written_whole
from omnimate.vehicle.errors import LogError
from tests.files.logs.any_frames import CLASSICAL, KINDS, any_frames, logs, write_log

# What each format holds: kinds of frames, interfaces, directions.
HELD = {
    ".log": (KINDS, ("can0", "can1"), (0, SENT)),
    ".log.gz": (KINDS, ("can0", "can1"), (0, SENT)),
    ".pcap": (KINDS, ("can0",), (0,)),
    ".pcapng": (KINDS, ("can0", "vcan7"), (0, SENT)),
    ".blf": (KINDS, ("can0", "can1"), (0, SENT)),
    ".asc": ([kind for kind in KINDS if not kind & ERROR], ("can0", "can1"), (0, SENT)),
    ".csv": (CLASSICAL, ("can0",), (0,)),
}
READERS = {
    ".log": can.CanutilsLogReader,
    ".blf": can.BLFReader,
    ".asc": can.ASCReader,
    ".csv": can.CSVReader,
}


def rows_for(suffix):
    """Logs that a format can hold, as close together as one of its files may be."""
    kinds, channels, directions = HELD[suffix]
    frame = any_frames(kinds=kinds, channels=channels, directions=directions)
    moments = st.lists(st.integers(0, 10**9), min_size=1, max_size=20).map(sorted)
    rows = moments.flatmap(lambda at: st.tuples(*(frame.map(lambda f, t=t: f._replace(time=t)) for t in at)))
    return rows.map(
        lambda rows: [row._replace(time=float(f"1763670000.{0:06d}") + row.time / 1e6) for row in rows]
    )


@pytest.mark.parametrize("suffix", HELD)
def test_every_suffix_is_tried(suffix):
    assert set(HELD) == set(SUFFIXES)
    assert log_suffix(type("Name", (), {"name": f"a{suffix}"})()) == suffix


@pytest.mark.parametrize("suffix", HELD)
@settings(max_examples=25)
@given(data=st.data())
def test_what_is_written_in_a_format_is_read_again(tmp_path, suffix, data):
    rows = data.draw(rows_for(suffix))
    path = tmp_path / f"some{suffix}"
    refused = write_log(rows, path, suffix)
    kept = [row for row in rows if not (suffix == ".asc" and row.flags & FD and not row.data)]
    assert len(refused) == len(rows) - len(kept)
    if not kept:
        return
    again = list(LogStream(path))
    assert [row._replace(time=0.0) for row in again] == [row._replace(time=0.0) for row in kept]
    first = kept[0].time if suffix == ".asc" else 0.0
    assert [row.time for row in again] == pytest.approx([row.time - first for row in kept], abs=2e-6)


@pytest.mark.parametrize("suffix", READERS)
@settings(max_examples=25)
@given(data=st.data())
def test_python_can_reads_the_same_frames(tmp_path, suffix, data):
    rows = data.draw(rows_for(suffix))
    if suffix == ".log":  # of candump's error frames it knows one class only
        rows = [row for row in rows if not row.flags & ERROR] or [Frame(1.0, 1)]
    path = tmp_path / f"some{suffix}"
    write_log(rows, path, suffix)
    kept = [row for row in rows if not (suffix == ".asc" and row.flags & FD and not row.data)]
    with READERS[suffix](path) as reader:
        messages = list(reader)
    for message, row in zip(messages, kept, strict=True):
        assert message.is_error_frame == bool(row.flags & ERROR)
        assert (message.is_fd, message.is_remote_frame) == (bool(row.flags & FD), bool(row.flags & REMOTE))
        if not row.flags & ERROR:
            assert (message.arbitration_id, bytes(message.data)) == (row.can_id, row.data)


def test_asc_holds_that_there_was_an_error_frame_and_no_more(tmp_path):
    write_log([Frame(1.0, 1, b"a"), Frame(1.5, 4, b"abc", ERROR)], tmp_path / "a.asc", ".asc")
    assert [(row.flags, row.data) for row in LogStream(tmp_path / "a.asc")] == [(0, b"a"), (ERROR, b"")]


def test_csv_refuses_can_fd_with_the_reason(tmp_path):
    assert "CAN FD" in write_log([Frame(1.0, 1, bytes(12), FD)], tmp_path / "a.csv", ".csv")[0]


def test_times_before_the_first_are_refused_where_the_format_counts_from_it(tmp_path):
    rows = [Frame(10.0, 1), Frame(9.0, 1)]
    assert "earlier than the first" in write_log(rows, tmp_path / "a.blf", ".blf")[0]
    assert write_log(rows, tmp_path / "a.pcap", ".pcap") == []


@given(logs(kinds=CLASSICAL))
def test_a_stream_gives_the_frames_that_reading_at_once_gives(tmp_path, rows):
    write_log(rows, tmp_path / "can.log", ".log")
    assert list(LogStream(tmp_path / "can.log")) == list(read_log(tmp_path / "can.log").frames)


def test_a_stream_and_an_array_add_up_the_same_relative_times(tmp_path):
    lines = (f" ({0 if n == 0 else 5 + n % 3:03d}.000100)  can0  181   [1]  00\n" for n in range(20))
    (tmp_path / "can.log").write_text("".join(lines))
    array = read_log(tmp_path / "can.log")
    assert array.blocks.is_added_up
    assert [row.time for row in LogStream(tmp_path / "can.log")] == pytest.approx(array.frames.time.tolist())


def test_what_is_left_out_is_counted_and_a_cut_line_is_told(tmp_path):
    (tmp_path / "can.log").write_bytes(b"(1.0) can0 181#01\ngarbage\n(1.1) can0 181#02\n(1.2) can0 181#0")
    stream = LogStream(tmp_path / "can.log")
    assert [row.data for row in stream] == [b"\1", b"\2"]
    assert stream.left_out == 2
    assert stream.truncated
    assert not stream.is_whole
    assert any("ends early" in problem for problem in stream.problems())


@pytest.mark.parametrize(("packer", "name"), [(bz2, "bzip2"), (lzma, "xz")])
def test_a_log_packed_by_another_than_gzip_names_the_packer(tmp_path, packer, name):
    path = tmp_path / "can.log"
    path.write_bytes(packer.compress(b"(1.000000) can0 181#00\n"))
    with pytest.raises(LogError, match=f"packed by {name}"):
        list(LogStream(path))


@pytest.mark.parametrize("encoding", ["utf-16-le", "utf-16-be"])
def test_a_log_that_an_editor_saved_as_utf_16_says_so(tmp_path, encoding):
    path = tmp_path / "can.log"
    path.write_text("\ufeff(1.000000) can0 181#00\n", encoding=encoding)
    with pytest.raises(LogError, match="it is UTF-16; save the file as UTF-8"):
        list(LogStream(path))


def test_a_file_without_a_frame_is_an_error(tmp_path):
    (tmp_path / "can.log").write_text("nothing\n")
    with pytest.raises(LogError, match="no CAN frame"):
        list(LogStream(tmp_path / "can.log"))
    with pytest.raises(LogError, match="cannot be read"):
        list(LogStream(tmp_path / "absent.log"))


@pytest.mark.parametrize("suffix", [".log", ".pcap", ".blf"])
def test_memory_does_not_grow_with_the_log(tmp_path, suffix, monkeypatch):
    monkeypatch.setattr(module, "BlockReader", lambda path, size=1 << 14: BlockReader(path, size))

    def rows(count):
        return (Frame(1e9 + 1e-4 * number, 0x181, b"12345678") for number in range(count))

    peaks = []
    for count in (6_000, 18_000):
        write_log(rows(count), tmp_path / f"a{suffix}", suffix)
        tracemalloc.start()
        assert sum(1 for _ in LogStream(tmp_path / f"a{suffix}")) == count
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 1.3 * peaks[0]


def test_mf4_is_read_as_python_can_wrote_it(tmp_path):
    pytest.importorskip("asammdf", reason="the extra mf4 is not installed")
    rows = [
        Frame(10.0, 0x181, b"ab"),
        Frame(10.5, 0x12345, b"", 1 | REMOTE, 4),
        Frame(11.0, 0x182, bytes(12), FD),
    ]
    with can.MF4Writer(tmp_path / "a.mf4") as writer:
        for row in rows:
            writer(message_of_frame(row))
    again = list(LogStream(tmp_path / "a.mf4"))
    assert [(row.can_id, row.flags, row.data) for row in again] == [(r.can_id, r.flags, r.data) for r in rows]
    assert [row.time - again[0].time for row in again] == pytest.approx([0.0, 0.5, 1.0], abs=1e-6)
    assert len(read_log(tmp_path / "a.mf4").frames) == 2


def test_an_mf4_is_read_by_python_can_frame_by_frame(tmp_path, monkeypatch):
    """Without asammdf, whose place is taken here by a reader that fails behind its second frame."""

    class Reader:
        def __init__(self, path):
            self.path = path

        def __enter__(self):
            return self

        def __exit__(self, *_error):
            pass

        def __iter__(self):
            yield message_of_frame(Frame(1.0, 0x181, b"ab"))
            yield message_of_frame(Frame(2.0, 0x182, bytes(12), FD))
            raise ValueError(self.path.name)

    monkeypatch.setitem(sys.modules, "asammdf", types.ModuleType("asammdf"))
    monkeypatch.setattr(can, "MF4Reader", Reader)
    (tmp_path / "a.mf4").write_bytes(b"MDF     4.10    ")
    stream = LogStream(tmp_path / "a.mf4")
    assert [(row.can_id, row.flags) for row in stream] == [(0x181, 0), (0x182, FD)]
    assert stream.truncated
    assert "asammdf cannot read on" in stream.skipped[0].reason


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # asammdf's destructor
def test_an_mf4_that_is_no_mf4_is_told(tmp_path):
    pytest.importorskip("asammdf", reason="the extra mf4 is not installed")
    (tmp_path / "a.mf4").write_bytes(b"MDF     4.10    " + bytes(200))
    with pytest.raises(LogError, match="asammdf cannot read on"):
        list(LogStream(tmp_path / "a.mf4"))
    gc.collect()


def test_nothing_is_left_of_a_file_that_could_not_be_written(tmp_path):
    def fill_the_disk():
        with written_whole(tmp_path / "a.log") as partial:
            partial.write_text("half")
            raise OSError(28, "No space left on device")

    with pytest.raises(LogError, match="cannot be written"):
        fill_the_disk()
    assert list(tmp_path.iterdir()) == []
