"""A log block by block is the log at once, in threads or not."""

from __future__ import annotations

import gzip

import numpy as np
import pytest

from omnimate.logs import blocks as module
from omnimate.logs.blocks import LogBlocks
from omnimate.logs.formats import block_reader
from omnimate.logs.frames import concatenate
from omnimate.logs.reading import read_log

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
    monkeypatch.setattr(block_reader.BlockReader.__init__, "__defaults__", (4096, False, 0, 0))
    if request.param == "threads":
        monkeypatch.setattr(module, "LARGE", 0)
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
    assert tuple(blocks.skipped) == whole.skipped
    assert blocks.truncated == whole.truncated


def test_a_form_that_is_read_frame_by_frame_comes_in_blocks_too(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "AT_ONCE", 10)
    path = tmp_path / "can.trc"
    head = ";$FILEVERSION=1.1\n;$STARTTIME=43000.0\n"
    lines = [f"{n + 1:6d}) {n * 1.5:11.1f}  Rx         0181  2  {n:02X} 00\n" for n in range(35)]
    path.write_text(head + "".join(lines))
    assert [len(piece) for piece in LogBlocks(path)] == [10, 10, 10, 5]
    assert len(read_log(path).frames) == 35
