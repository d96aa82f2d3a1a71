"""A log block by block is the log at once, in threads or not."""

import gzip

import can
import numpy as np
import pytest

from omnimate.files.logs import blocks as module
from omnimate.files.logs.blocks import LogBlocks, read_log
from omnimate.files.logs.formats import block_reader
from omnimate.files.logs.frames import concatenate

LINES = [f"({1700000000 + 0.001 * n:.6f}) can{n % 2} {0x180 + n % 7:03X}#{n:08X}\n" for n in range(3000)]
BROKEN = [
    *LINES[:100],
    "garbage\n",
    *LINES[100:2500],
    "(1.0) can0 999#00\n",
    *LINES[2500:],
    "(1700000009.0) can0 18",
]


@pytest.fixture(params=["one thread", "threads"])
def is_parallel(request, monkeypatch):
    """Read in blocks of 4 kB, by the interpreter alone or by threads of machine code."""
    monkeypatch.setattr(block_reader.BlockReader.__init__, "__defaults__", (4096,))
    if request.param == "threads":
        monkeypatch.setattr(module, "PARALLEL_SIZE", 0)
    return request.param == "threads"


@pytest.mark.usefixtures("is_parallel")
@pytest.mark.parametrize("pack", [lambda data: data, gzip.compress], ids=["plain", "gzipped"])
@pytest.mark.parametrize("lines", [LINES, BROKEN], ids=["whole", "broken"])
def test_the_blocks_are_the_log(tmp_path, monkeypatch, lines, pack):
    path = tmp_path / "can.log"
    path.write_bytes(pack("".join(lines).encode()))
    blocks = LogBlocks(path, workers=2)
    pieces = list(blocks)
    assert len(pieces) > 5
    monkeypatch.undo()
    whole = read_log(path)
    frames = concatenate(pieces)
    assert len(frames) == 3000
    for field in ("time", "can_id", "length", "data", "flags"):
        assert np.array_equal(getattr(frames, field), getattr(whole.frames, field))
    names = [[log.channels[number] for number in log.channel] for log in (frames, whole.frames)]
    assert names[0] == names[1]
    assert blocks.skipped == whole.blocks.skipped
    assert blocks.truncated == whole.blocks.truncated


def test_a_form_that_is_read_frame_by_frame_comes_in_blocks_too(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "FRAMES_PER_BLOCK", 10)
    path = tmp_path / "can.trc"
    head = ";$FILEVERSION=1.1\n;$STARTTIME=43000.0\n"
    lines = [f"{n + 1:6d}) {n * 1.5:11.1f}  Rx         0181  2  {n:02X} 00\n" for n in range(35)]
    path.write_text(head + "".join(lines))
    assert [len(piece) for piece in LogBlocks(path)] == [10, 10, 10, 5]
    assert len(read_log(path).frames) == 35


@pytest.mark.usefixtures("is_parallel")
def test_times_since_the_frame_before_are_added_up_over_the_blocks(tmp_path):
    path = tmp_path / "can.log"
    path.write_text(
        "".join(f" ({0 if n == 0 else 5 + n % 3:03d}.000100)  can0  181   [1]  00\n" for n in range(900))
    )
    log = LogBlocks(path, workers=2)
    pieces = list(log)
    assert len(pieces) > 5
    assert log.is_added_up
    whole = np.cumsum([0.0001 if n == 0 else 5.0001 + n % 3 for n in range(900)])
    assert np.allclose(concatenate(pieces).time, whole)


@pytest.mark.usefixtures("is_parallel")
def test_a_clock_that_goes_back_between_two_blocks_or_in_one_is_told(tmp_path):
    path = tmp_path / "can.log"
    times = [1700000000 + (n if n < 500 else n - 300 if n < 505 else n - 310) for n in range(1000)]
    path.write_text("".join(f"({time:.6f}) can0 181#{n:08X}\n" for n, time in enumerate(times)))
    log = LogBlocks(path, workers=2)
    assert sum(len(piece) for piece in log) == log.frames == 1000
    assert log.jumps == 2
    assert log.first_jump == (501, times[499], times[500])
    assert "the clock goes back 2 times, first at frame 501" in "".join(log.problems())


def test_what_is_kept_of_a_log_without_frames_is_a_thousand_lines(tmp_path):
    path = tmp_path / "can.log"
    path.write_text("garbage\n" * 3000 + LINES[0])
    log = LogBlocks(path)
    assert sum(len(piece) for piece in log) == 1
    assert (len(log.skipped), log.left_out) == (module.MAX_SKIPPED_LINES, 3000)
    assert list(log.problems())[-1].endswith("skipped: 2000 lines more")


def test_interfaces_keep_their_numbers_from_block_to_block_in_any_format(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "FRAMES_PER_BLOCK", 50)
    path = tmp_path / "can.asc"
    with can.ASCWriter(path) as writer:
        for n in range(200):
            channel = 0 if n < 70 else 1
            writer(can.Message(1.7e9 + 0.001 * n, 0x181, is_extended_id=False, data=[5], channel=channel))
    pieces = list(LogBlocks(path))
    assert len(pieces) == 4
    names = [name for piece in pieces for name in np.array(piece.channels)[piece.channel].tolist()]
    assert names == [names[0]] * 70 + [names[-1]] * 130
    assert pieces[-1].channels == pieces[1].channels
