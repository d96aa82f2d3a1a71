"""The speed at which a candump log loads.

Peer: python-can's reader, on the same file.

Usage: python -m studies.speed.log_reading [frames]
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import can
import numpy as np

from omnimate.files.logs.blocks import read_log
from studies.benchmark import best, options

FRAMES = 1_000_000
TARGET = 10.0  # times python-can's reader
ROUNDS = 3  # the best counts: the machine may be shared


def write_log(path: Path, count: int) -> None:
    """Write SYNC, seven TPDOs and now and then a heartbeat, as a robot with seven encoders logs them."""
    generator = np.random.default_rng(1)
    payloads = generator.integers(0, 2**32, count).tolist()
    with path.open("w", encoding="ascii") as file:
        for index in range(count):
            time_stamp = 1_700_000_000.0 + 0.001_25 * index
            place = index % 8
            if index % 400 == 399:
                file.write(f"({time_stamp:.6f}) can0 70{place}#05\n")
            elif place == 0:
                file.write(f"({time_stamp:.6f}) can0 080#\n")
            else:
                width = 16 if place < 5 else 8
                file.write(f"({time_stamp:.6f}) can0 18{place}#{payloads[index]:0{width}X}\n")


def main() -> int:
    count = options(__doc__, {"frames": FRAMES}).frames
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "can.log"
        write_log(path, count)
        theirs = count / best(lambda: sum(1 for _ in can.CanutilsLogReader(path)), ROUNDS)  # [frames/s]
        ours = count / best(lambda: read_log(path), ROUNDS)
    print(f"candump log of {count} frames")
    print(f"  python-can CanutilsLogReader {theirs / 1e6:8.3f} million frames/s")
    print(f"  omnimate.files.logs.read_log       {ours / 1e6:8.3f} million frames/s")
    print(f"  ratio                        {ours / theirs:8.1f}   (wanted: {TARGET:.0f} or more)")
    return 0 if ours >= TARGET * theirs else 1


if __name__ == "__main__":
    sys.exit(main())
