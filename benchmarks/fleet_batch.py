"""What a night's batch costs: processor time and memory of `fleet run`, on a hall's laps of five minutes.

Processor time counts, because the machine may be shared; simulating and writing the laps does not.

Peer, in the same run: the same batch of another day's laps.

Usage: python -m benchmarks.fleet_batch [--robots 24] [--diagnose]
"""

from __future__ import annotations

import argparse
import resource
import sys
import tempfile
import time
from pathlib import Path

from omnimate.fleet.batch.run import run_batch
from omnimate.vcan_sim.hall.hall import draw_hall
from omnimate.vcan_sim.hall.store import write_store

LAPS, WANTED, CORES = 1000, 1800.0, 2  # laps of a day, and their time [s] on some cores
MEMORY = 2.0  # [GB]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robots", type=int, default=24)
    parser.add_argument("--minutes", type=float, default=5.0)
    parser.add_argument("--diagnose", action="store_true", help="whole diagnoses where triage asks for them")
    options = parser.parse_args()
    hall = draw_hall(options.robots, 5, sick=0, places=3, seed=7)
    with tempfile.TemporaryDirectory() as place:
        store, spent = Path(place) / "store", []
        write_store(hall, store, range(3), 1, options.minutes)
        for number, day in enumerate(
            ("2026-03-02", "2026-03-03", "*")
        ):  # compiles; one day; all that is left
            began = time.process_time()
            outcome = run_batch(str(store), f"{place}/results", day=day, diagnosed=options.diagnose)
            spent.append((outcome.done, time.process_time() - began))
            print(f"  {outcome.done} laps: {spent[number][1]:.1f} s of processor time")
    laps, seconds = spent[1][0] + spent[2][0], spent[1][1] + spent[2][1]
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    day = seconds / laps * LAPS / CORES
    print(
        f"{seconds / laps:.2f} s for a lap; {LAPS} laps on {CORES} cores in {day / 60.0:.1f} minutes "
        f"(wanted: {WANTED / 60.0:.0f}); {memory:.2f} GB (wanted: below {MEMORY:.0f})"
    )
    return 0 if day <= WANTED and memory < MEMORY else 1


if __name__ == "__main__":
    sys.exit(main())
