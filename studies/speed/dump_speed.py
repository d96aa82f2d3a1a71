"""The time in which `omnimate dump` reads and prints a candump log, as a whole process.

Peer: `log2long` of can-utils, a C program that reads the same log and prints it as `candump -ta` does. The
best of several rounds counts, because the machine may be shared; the least processor time of the rounds,
which other load hardly changes, stands beside it.

Usage: python -m studies.speed.dump_speed [frames]
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

from studies.speed.log_reading import write_log

FRAMES = 1_000_000
ROUNDS = 7
CALL = "import sys; from omnimate.cli.main import main; sys.argv[0] = 'omnimate'; main()"
READING, PRINTING = 1.2, 2.0  # times log2long
VERBS = {
    "read, and rates": (("--rates",), READING),
    "printed as -L": ((), PRINTING),
    "printed as -ta": (("--form", "ta"), PRINTING),
}


class Cost(NamedTuple):
    """What a process takes: time by the wall and of processors [s]."""

    wall: float
    processor: float


def cost(command: list[str], log: Path) -> Cost:
    """Return what a process takes that reads the log on its standard input and prints."""
    with log.open("rb") as source:
        start, before = time.perf_counter(), os.times()
        subprocess.run(command, stdin=source, stdout=subprocess.DEVNULL, check=True)
        wall, after = time.perf_counter() - start, os.times()
    used = after.children_user + after.children_system - before.children_user - before.children_system
    return Cost(wall, used)


def main() -> int:
    peer = shutil.which("log2long")
    if peer is None:
        print("log2long of can-utils is not installed: nothing to compare with")
        return 0
    count = int(sys.argv[1]) if len(sys.argv) > 1 else FRAMES
    rounds: dict[str, list[Cost]] = {}
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
                rounds.setdefault(name, []).append(cost(command, log))
    best = {name: Cost(*map(min, zip(*costs, strict=True))) for name, costs in rounds.items()}
    peer_cost = best["log2long"]
    print(f"candump log of {count} frames, whole processes; load {os.getloadavg()[0]:.1f} at the end")
    print(f"  {'':18}  {'wall':>8}  ratio  {'processor':>9}  ratio")
    print(f"  {'log2long':18}  {peer_cost.wall:6.2f} s         {peer_cost.processor:7.2f} s")
    ratios = {name: best[name].wall / peer_cost.wall for name in VERBS}
    for name, (_, wanted) in VERBS.items():
        used = best[name].processor
        print(
            f"  {name:18}  {best[name].wall:6.2f} s  {ratios[name]:5.2f}  {used:7.2f} s  "
            f"{used / peer_cost.processor:5.2f}   (wanted: {wanted:g} or less by the wall)"
        )
    return 0 if all(ratios[name] <= wanted for name, (_, wanted) in VERBS.items()) else 1


if __name__ == "__main__":
    sys.exit(main())
