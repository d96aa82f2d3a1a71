"""Time and memory in which `omnimate export` writes a candump log in other formats, as a whole process.

Peer: python-can's reader and writer of the same formats, in a process that does nothing else. The memory of a
log that is four times as long must not be more than `GROWTH` times that of the short one.

Usage: python -m studies.speed.export_speed [frames]
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from pathlib import Path

from studies.benchmark import OMNIMATE, options, process_cost

FRAMES = 400_000
GROWTH = 1.15
SUFFIXES = (".pcap", ".pcapng", ".blf", ".asc", ".csv", ".parquet", ".mcap")
PEERS = (".blf", ".asc", ".csv")  # formats that python-can writes
EXPORT = (*OMNIMATE, "export")
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


def main() -> int:
    count = options(__doc__, {"frames": FRAMES}).frames
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
            small = process_cost([*EXPORT, str(short), f"{folder}/short-out{suffix}"])
            large = process_cost([*EXPORT, str(long), f"{folder}/long-out{suffix}"])
            growth = large.memory / small.memory
            is_good &= growth <= GROWTH
            words = f"  {suffix:<9} {large.processor:6.1f} s   {large.memory:4.0f} MB, {growth:4.2f} times"
            if suffix in PEERS:
                peer = process_cost([sys.executable, "-c", PEER, str(long), f"{folder}/peer{suffix}"])
                words += f"   python-can {peer.processor:6.1f} s"
            print(words, flush=True)
        print(f"  (wanted: memory {GROWTH:g} times or less; {time.monotonic() - began:.0f} s in all)")
    return 0 if is_good else 1


if __name__ == "__main__":
    sys.exit(main())
