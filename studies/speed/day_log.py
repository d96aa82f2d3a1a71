"""How fast a day of a saturated 1 Mbit/s bus (7.8e8 frames) is read and decoded, and in how much memory.

A smaller log of the same traffic is written in each form, and read by `LogBlocks`, block by block; the values
of a robot's seven encoders are decoded on the way. Each reading is a process of its own, whose highest memory
is that of the operating system.

Peer: a log that is four times as long, which shows that the memory does not grow, and, without what a process
takes to start, the rate of a day.

The machine may be shared: the processor time of a frame says what two cores of its own would reach, as long
as the thread that hands out and decodes the blocks takes less than half of it.

Usage: python -m studies.speed.day_log [million frames]
"""

from __future__ import annotations

import gzip
import os
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import can
import numpy as np

from omnimate.files.logs.blocks import LogBlocks
from omnimate.files.logs.decoding import vehicle_signals
from omnimate.files.logs.formats.candump_text import candump_text
from omnimate.files.logs.frames import Frames
from omnimate.vcan_sim.reference import reference_vehicle
from studies.benchmark import cost, options

MILLIONS = 4.0  # 164 MB: the shorter log, too, is one that threads read
DAY = 7.8e8  # frames: 1 Mbit/s, 110 bits each
RATE = 9028.0  # frames/s
TARGET = 10.0  # million frames/s, on two cores
PIECE = 1 << 18  # frames written at a time
FEW = 50_000  # frames of a form that is read frame by frame


def traffic(count: int) -> Iterator[Frames]:
    """Yield SYNC and seven encoders' PDOs in pieces, `count` frames in all."""
    random = np.random.default_rng(1)
    for start in range(0, count, PIECE):
        index = np.arange(start, min(start + PIECE, count))
        place = index % 8
        length = np.where(place == 0, 0, np.where(place < 5, 8, 4)).astype(np.uint8)
        data = random.integers(0, 256, (len(index), 8), np.uint8)
        data[np.arange(8) >= length[:, None]] = 0
        can_id = np.where(place == 0, 0x080, 0x180 + place).astype(np.uint32)
        none = np.zeros(len(index), np.uint8)
        yield Frames(1.7e9 + index / RATE, can_id, length, data, none, none)


def write_text(path: Path, count: int) -> None:
    with path.open("wb") as file:
        for frames in traffic(count):
            file.writelines(candump_text(frames))


def write_gzip(path: Path, count: int) -> None:
    with gzip.open(path, "wb", compresslevel=1) as file:
        for frames in traffic(count):
            for piece in candump_text(frames):
                file.write(piece)


def write_by_python_can(path: Path, count: int) -> None:
    with can.Logger(path) as logger:
        for frames in traffic(count):
            for frame in frames:
                logger.on_message_received(
                    can.Message(frame.time, frame.can_id, is_extended_id=False, data=frame.data, channel=0)
                )


FORMS: dict[str, tuple[str, Callable[[Path, int], None], int]] = {
    "candump -L, gzipped": ("day.log.gz", write_gzip, 0),
    "Vector BLF": ("day.blf", write_by_python_can, FEW),
    "Vector ASC": ("day.asc", write_by_python_can, FEW),
    "PEAK TRC": ("day.trc", write_by_python_can, FEW),
}


class Reading(NamedTuple):
    """The frames/s of a log, the processor time of a frame [ns], and the highest memory [MB]."""

    rate: float
    used: float
    memory: float


def read_and_decode(path: Path) -> tuple[int, float]:
    """Return the number of frames of a log, and the sum of all decoded values, so that none is left out."""
    signals = vehicle_signals(reference_vehicle())
    count, total = 0, 0.0
    for frames in LogBlocks(path):
        count += len(frames)
        for cob_id, carried in signals.items():
            mine = frames.select(np.flatnonzero(frames.can_id == cob_id))
            total += sum(float(signal.values(mine).sum()) for signal in carried if len(mine))
    return count, total


def report(path: Path) -> None:
    """Print the frames/s of one reading, the processor time of a frame [ns], and the highest memory [MB]."""
    counts: list[int] = []
    used = cost(lambda: counts.append(read_and_decode(path)[0]))
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(counts[0] / used.wall, 1e9 * used.processor / counts[0], memory)


def measured(write: Callable[[Path, int], None], path: Path, frames: int) -> Reading:
    """Write a log, and return what `report` prints in a process of its own."""
    write(path, frames)
    call = [sys.executable, "-m", "studies.speed.day_log", "--read", str(path)]
    said = subprocess.run(call, capture_output=True, text=True, check=True).stdout
    path.unlink()
    return Reading(*map(float, said.split()))


def show(name: str, frames: int, reading: Reading) -> None:
    hours = DAY / reading.rate / 3600
    day = f"{hours * 60:.1f} min" if hours < 1 else f"{hours:.1f} h"
    print(
        f"{name:22}{frames:12}{reading.rate / 1e6:9.2f}{reading.used:14.0f}{reading.memory:7.0f}{day:>10}",
        flush=True,
    )


def main() -> int:
    given = options(__doc__, {"millions": MILLIONS}, read=None)
    if given.read:
        report(Path(given.read))
        return 0
    count = int(given.millions * 1e6)
    print(f"{os.cpu_count()} processors, load {os.getloadavg()[0]:.1f} at the start")
    print(f"{'form':22}{'frames':>12}{'10^6/s':>9}{'ns of a core':>14}{'MB':>7}{'a day':>10}")
    with tempfile.TemporaryDirectory() as folder:
        measured(write_text, Path(folder) / "day.log", count)  # numba compiles, which is not of the reading
        short, long = (
            measured(write_text, Path(folder) / "day.log", frames) for frames in (count, 4 * count)
        )
        show("candump -L", count, short)
        show("candump -L", 4 * count, long)
        for name, (file, write, frames) in FORMS.items():
            show(name, frames or count, measured(write, Path(folder) / file, frames or count))
    passed = (4 * count / long.rate - count / short.rate) / (3 * count)
    used = (4 * long.used - short.used) / 3
    print(
        f"candump -L, the difference of both: {1e-6 / passed:.1f} million frames/s, {used:.0f} ns of a core"
    )
    print(f"two cores of its own, by processor time: {2e3 / used:.1f} million frames/s (wanted: {TARGET:g})")
    return 0 if max(1e-6 / passed, 2e3 / used) >= TARGET else 1


if __name__ == "__main__":
    sys.exit(main())
