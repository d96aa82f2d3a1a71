"""The time in which `omnimate dump` reads and prints a candump log, as a whole process.

Peer: `log2long` of can-utils, a C program that reads the same log and prints it as `candump -ta` does. The
best of several rounds counts, because the machine may be shared; the least processor time of the rounds,
which other load hardly changes, stands beside it.

Usage: python -m studies.speed.dump_speed [frames]
"""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
from pathlib import Path

from studies.benchmark import OMNIMATE, Cost, least, options, process_cost
from studies.speed.log_reading import write_log

FRAMES = 1_000_000
ROUNDS = 7
READING, PRINTING = 1.2, 2.0  # times log2long
VERBS = {
    "read, and rates": (("--rates",), READING),
    "printed as -L": ((), PRINTING),
    "printed as -ta": (("--form", "ta"), PRINTING),
}


def main() -> int:
    count = options(__doc__, {"frames": FRAMES}).frames
    peer = shutil.which("log2long")
    if peer is None:
        print("log2long of can-utils is not installed: nothing to compare with")
        return 0
    rounds: dict[str, list[Cost]] = {}
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / "can.log"
        write_log(log, count)
        calls = {"log2long": [peer]}
        calls |= {name: [*OMNIMATE, "dump", str(log), *arguments] for name, (arguments, _) in VERBS.items()}
        for _ in range(ROUNDS):
            for name, command in calls.items():
                rounds.setdefault(name, []).append(process_cost(command, log))
    best = {name: least(costs) for name, costs in rounds.items()}
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
