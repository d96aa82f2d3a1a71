"""The writer of live logs: nothing that was written is lost."""

import errno
import os
import threading

import pytest

from omnimate.files.logs.blocks import read_log
from omnimate.files.logs.formats.candump_writer import CandumpWriter
from omnimate.files.logs.frames import REMOTE, Frame

FRAMES = [Frame(1700000000.0 + 0.001 * index, 0x180 + index % 8, bytes(index % 9)) for index in range(100)]


def write(path, **options):
    """A writer with all frames written, not closed."""
    writer = CandumpWriter(path, **options)
    for frame in FRAMES:
        writer.write_frame(frame)
    return writer


def test_a_frame_is_in_the_file_once_it_is_synced_without_closing_it(tmp_path):
    writer = CandumpWriter(tmp_path / "can.log", sync_interval=3600.0)
    writer.write_frame(Frame(1700000000.00025, 0x181, b"\x00\x10"))
    writer.sync()
    assert (tmp_path / "can.log").read_bytes() == b"(1700000000.000250) can0 181#0010\n"
    writer.write_frame(Frame(1700000001.0, 0x701, flags=REMOTE, length=1, channel="can1"))
    writer.sync()
    assert (tmp_path / "can.log").read_bytes().endswith(b"(1700000001.000000) can1 701#R1\n")
    writer.close()


def test_the_thread_puts_the_file_on_disk_by_itself(tmp_path, monkeypatch):
    synced = threading.Event()
    monkeypatch.setattr(os, "fsync", lambda _handle: synced.set())
    with CandumpWriter(tmp_path / "can.log", sync_interval=0.001) as writer:
        writer.write_frame(Frame(1.0, 0x080))
        assert synced.wait(60.0)


def test_an_unfinished_gzip_log_holds_all_that_was_synced(tmp_path):
    writer = write(tmp_path / "can.log.gz", sync_interval=3600.0)
    writer.sync()
    result = read_log(tmp_path / "can.log.gz")
    assert len(result.frames) == len(FRAMES)
    assert result.blocks.truncated
    writer.close()
    assert not read_log(tmp_path / "can.log.gz").blocks.truncated


def test_a_new_writer_replaces_an_old_log_and_closing_twice_does_nothing(tmp_path):
    write(tmp_path / "can.log").close()
    writer = CandumpWriter(tmp_path / "can.log")
    writer.write_frame(Frame(1.0, 1))
    writer.close()
    writer.close()
    writer.sync()
    assert len(read_log(tmp_path / "can.log").frames) == 1


def refuse(_handle):
    raise OSError(errno.ENOSPC, "No space left on device")


def test_while_the_disk_refuses_frames_are_left_out_and_what_it_took_is_whole(tmp_path, monkeypatch):
    writer = write(tmp_path / "can.log", sync_interval=3600.0)
    with monkeypatch.context() as full:
        full.setattr(os, "fsync", refuse)
        for attempt in (writer.sync, lambda: writer.write_frame(Frame(1700000001.0, 0x701))):
            with pytest.raises(OSError, match="No space left"):
                attempt()
    writer.sync()
    writer.write_frame(Frame(1700000002.0, 0x702))
    writer.close()
    frames = list(read_log(tmp_path / "can.log").frames)
    assert [frame.can_id for frame in frames[len(FRAMES) - 1 :]] == [FRAMES[-1].can_id, 0x702]


def test_the_thread_asks_a_disk_again_that_has_refused(tmp_path, monkeypatch):
    calls, synced = [], threading.Event()

    def refuse_once(handle):
        calls.append(handle)
        if len(calls) == 1:
            refuse(handle)
        synced.set()

    monkeypatch.setattr(os, "fsync", refuse_once)
    with CandumpWriter(tmp_path / "can.log", sync_interval=0.001):
        assert synced.wait(60.0)


def test_a_full_disk_is_an_error_of_write_and_close_and_the_file_is_closed():
    writer = CandumpWriter("/dev/full", sync_interval=3600.0)
    refused = 0
    for _ in range(1000):
        try:
            writer.write_frame(Frame(1.0, 0x701))
        except OSError as error:
            refused += error.errno == errno.ENOSPC
    assert refused > 500
    with pytest.raises(OSError, match="No space left"):
        writer.close()
    writer.close()
