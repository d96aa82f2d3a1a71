"""The time in which `omnimate dump` reads and prints a candump log, as a whole process.

Peer: `log2long` of can-utils, a C program that reads the same log and prints it as `candump -ta` does. The
best of several rounds counts, because the machine may be shared.

Usage: python -m benchmarks.dump_speed [frames]
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from benchmarks.log_reading import write_log

FRAMES = 1_000_000
ROUNDS = 7
CALL = "import sys; from omnimate.cli.main import main; sys.argv[0] = 'omnimate'; main()"
READING, PRINTING = 1.2, 2.0  # times log2long
VERBS = {
    "read, and rates": (("--rates",), READING),
    "printed as -L": ((), PRINTING),
    "printed as -ta": (("--form", "ta"), PRINTING),
}


def seconds(command: list[str], log: Path) -> float:
    """Return the time of a process that reads the log on its standard input and prints [s]."""
    with log.open("rb") as source:
        start = time.perf_counter()
        subprocess.run(command, stdin=source, stdout=subprocess.DEVNULL, check=True)
        return time.perf_counter() - start


def main() -> int:
    peer = shutil.which("log2long")
    if peer is None:
        print("log2long of can-utils is not installed: nothing to compare with")
        return 0
    count = int(sys.argv[1]) if len(sys.argv) > 1 else FRAMES
    best: dict[str, float] = {}
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / "can.log"
        write_log(log, count)
        calls = {"log2long": [peer]}
        calls |= {
            name: [sys.executable, "-c", CALL, "dump", str(log), *options]
            for name, (options, _) in VERBS.items()
        }
        for _ in range(ROUNDS):
            for name, command in calls.items():
                best[name] = min(best.get(name, float("inf")), seconds(command, log))
    print(f"candump log of {count} frames, whole processes")
    print(f"  log2long            {best['log2long']:6.2f} s")
    ratios = {name: best[name] / best["log2long"] for name in VERBS}
    for name, (_, wanted) in VERBS.items():
        print(f"  {name:<18}  {best[name]:6.2f} s   ratio {ratios[name]:4.1f}   (wanted: {wanted:g} or less)")
    return 0 if all(ratios[name] <= wanted for name, (_, wanted) in VERBS.items()) else 1


if __name__ == "__main__":
    sys.exit(main())
