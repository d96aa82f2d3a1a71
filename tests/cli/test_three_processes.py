"""Three processes on one bus: the simulated vehicle, our recorder, and python-can's own tools."""

import re
import signal
import subprocess
import sys
from collections import Counter
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from omnimate.files.logs.blocks import read_log
from omnimate.files.recordings.folder import load_recording

TOOLS = Path(sys.executable).parent
PATIENCE = 120.0  # [s] of a wait that normally ends at once
ENCODERS = range(0x181, 0x188)  # their TPDOs
HEARTBEATS = {0x700 + node for node in (*range(1, 8), *range(11, 15))}


def _as_from_a_terminal():
    """Let Ctrl-C end a command: a shell's background jobs ignore it, and hand that on."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


@contextmanager
def started(name, *arguments):
    """Start a command of this environment, whose output can be read line by line; end it in any case."""
    process = subprocess.Popen(
        [TOOLS / name, *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env={"PYTHONUNBUFFERED": "1", "COLUMNS": "120"},
        preexec_fn=_as_from_a_terminal,  # noqa: PLW1509  # the test has one thread
    )
    with process:
        try:
            yield process
        finally:
            process.kill()


def await_line(process, pattern):
    """Read a process's output up to a line with a pattern; return the match."""
    for line in process.stdout:
        if match := re.search(pattern, line):
            return match
    raise AssertionError(f"{process.args}: ended without {pattern!r}")


@pytest.fixture
def bus():
    """The port of a simulated vehicle's bus, whose robot drives by itself."""
    drive = ("--drive", "umbmark", "--side", 1, "--runs", 1)
    with started("omnimate", "sim", "--listen", "127.0.0.1:0", *drive) as sim:
        yield int(await_line(sim, r"listening on 127\.0\.0\.1:(\d+)")[1])
        sim.send_signal(signal.SIGTERM)
        assert sim.wait(PATIENCE) == 0


def contents(log):
    return Counter((frame.can_id, frame.data) for frame in read_log(log).frames)


def payloads(log, can_id):
    """Return what an identifier carried, in order."""
    return [frame.data for frame in read_log(log).frames if frame.can_id == can_id]


def ended(process):
    """Return what a process still prints until it ends by itself."""
    return process.communicate(timeout=PATIENCE)[0]


def test_our_recorder_and_can_logger_keep_the_same_frames(bus, tmp_path):
    """can_logger begins earlier and ends later; all that we recorded, sent or received, is in its log.

    How many SYNCs there are, and how many answers are late, depends on the machine. Where all answers of 2 s
    are late, the recorder reports nodes that have never answered, with exit code 1; it keeps all frames.
    """
    where = ("--bus-kwargs", "host=127.0.0.1", f"port={bus}")
    url = f"socketcand://127.0.0.1:{bus}/can0"
    with started(
        "can_logger", *where, "-i", "socketcand", "-c", "can0", "-f", tmp_path / "other.log"
    ) as logger:
        await_line(logger, "Can Logger")
        with started("omnimate", "record", tmp_path / "ours", "--bus", url, "--seconds", 3.0) as recorder:
            assert "recording:" in ended(recorder)
        logger.send_signal(signal.SIGINT)
        ended(logger)
    ours, theirs = tmp_path / "ours/can.log", tmp_path / "other.log"
    assert contents(ours) - contents(theirs) == Counter(), "frames that only our recorder saw"
    for encoder in ENCODERS:
        kept = payloads(ours, encoder)
        assert kept
        assert kept == payloads(theirs, encoder)[: len(kept)], "answers that only can_logger saw"
    extra = {can_id for can_id, _ in contents(theirs) - contents(ours)}
    assert extra <= {*HEARTBEATS, *ENCODERS}, "only heartbeats and late answers came after us"
    assert len(load_recording(tmp_path / "ours")) == len(payloads(ours, 0x080))


@pytest.mark.slow
def test_can_player_replays_a_log_into_our_recorder(bus, omnimate, tmp_path):
    """What python-can's player sends is recorded frame by frame, nothing is sent, and it makes samples."""
    assert omnimate("simulate", tmp_path / "drive", "--protocol", "eight", "--side", 1, "--runs", 1).code == 0
    source = tmp_path / "source.log"
    lines = (tmp_path / "drive/can.log").read_text().splitlines(keepends=True)
    source.write_text("".join(lines[:1600]))
    where = ("--bus-kwargs", "host=127.0.0.1", f"port={bus}")
    url = f"socketcand://127.0.0.1:{bus}/can0"
    with started("omnimate", "record", tmp_path / "ours", "--bus", url, "--listen-only") as recorder:
        await_line(recorder, "listening")
        with started("can_player", *where, "-i", "socketcand", "-c", "can0", source) as player:
            ended(player)
        assert player.returncode == 0
        assert "recording:" in ended(recorder)
    sent, heard = contents(source), contents(tmp_path / "ours/can.log")
    assert (sent - heard).total() <= 2, "the player may close its connection on its last frames"
    recording = load_recording(tmp_path / "ours")
    expected = load_recording(tmp_path / "drive")
    moved = np.ptp(recording.channel_counts("a.left"))
    assert moved == np.ptp(expected.channel_counts("a.left")[: len(recording)])
