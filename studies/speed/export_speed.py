"""Time and memory in which `omnimate export` writes a candump log in other formats, as a whole process.

Peer: python-can's reader and writer of the same formats, in a process that does nothing else. The memory of a
log that is four times as long must not be more than `GROWTH` times that of the short one.

Usage: python -m studies.speed.export_speed [frames]
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

FRAMES = 400_000
GROWTH = 1.15
SUFFIXES = (".pcap", ".pcapng", ".blf", ".asc", ".csv", ".parquet", ".mcap")
PEERS = (".blf", ".asc", ".csv")  # formats that python-can writes
EXPORT = (
    "import sys; from omnimate.cli.main import main; sys.argv = ['omnimate', 'export', *sys.argv[1:]]; main()"
)
# In a process of its own: the largest memory of a process counts from that of the one that starts it.
WRITE = """
import sys
from pathlib import Path
from studies.speed.log_reading import write_log
write_log(Path(sys.argv[1]), int(sys.argv[2]))
"""
PEER = """
import sys, can
with can.LogReader(sys.argv[1]) as reader, can.Logger(sys.argv[2]) as writer:
    for message in reader:
        writer(message)
"""


class Run(NamedTuple):
    """What a process took: time of the processor [s], and its largest memory [MB]."""

    cpu: float
    memory: float


def run(program: str, source: Path, target: Path) -> Run:
    """Run a process that reads a log and writes another."""
    process = subprocess.Popen(
        [sys.executable, "-c", program, str(source), str(target)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    _, status, usage = os.wait4(process.pid, 0)
    if status:
        raise RuntimeError(f"{target.name}: the process ended with status {status}")
    return Run(usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024.0)


def main() -> int:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else FRAMES
    is_good = True
    print(
        f"candump log of {count} frames, whole processes: processor time, and memory beside a quarter of it"
    )
    with tempfile.TemporaryDirectory() as folder:
        long, short = Path(folder) / "long.log", Path(folder) / "short.log"
        for log, frames in ((long, count), (short, count // 4)):
            subprocess.run([sys.executable, "-c", WRITE, str(log), str(frames)], check=True)
        began = time.monotonic()
        for suffix in SUFFIXES:
            small = run(EXPORT, short, Path(folder) / f"short-out{suffix}")
            large = run(EXPORT, long, Path(folder) / f"long-out{suffix}")
            growth = large.memory / small.memory
            is_good &= growth <= GROWTH
            words = f"  {suffix:<9} {large.cpu:6.1f} s   {large.memory:4.0f} MB, {growth:4.2f} times"
            if suffix in PEERS:
                words += f"   python-can {run(PEER, long, Path(folder) / f'peer{suffix}').cpu:6.1f} s"
            print(words, flush=True)
        print(f"  (wanted: memory {GROWTH:g} times or less; {time.monotonic() - began:.0f} s in all)")
    return 0 if is_good else 1


if __name__ == "__main__":
    sys.exit(main())
