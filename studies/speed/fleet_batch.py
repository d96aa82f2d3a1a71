"""What a day's batch costs: processor time and peak memory of `fleet run` on a hall's laps of five minutes.

The laps are those of a hall with faulty robots and bad places, one for each robot. Processor time counts,
because the machine may be shared; simulating and writing the laps does not.

Peer, in the same run: twice as many laps, which should take twice the time.

Usage: python -m studies.speed.fleet_batch [--laps 1000] [--minutes 5] [--no-diagnose]
"""

from __future__ import annotations

import multiprocessing
import resource
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

from omnimate.fleet.batch.run import run_batch
from omnimate.fleet.batch.tables import decode_columns
from omnimate.fleet.hall.hall import date_of, draw_hall, write_store
from studies.benchmark import Cost, cost, options

LAPS, WANTED, CORES = 1000, 1800.0, 2  # laps of a day, and their time [s] on some cores
MEMORY = 2.0  # [GB]
LINEAR = 2.1  # times the time, that twice the laps may take
DAYS, LAST = 12, 10  # days of the hall, and the one whose laps are driven: faults began before
FAULTY, PLACES = 0.03, 20  # part of the robots, and number of places, as in the hall of 1000 robots


def write_laps(folder: Path, laps: int, minutes: float) -> None:
    """Write a store of some laps and one of twice as many, and one of a lap of each type of robot."""
    hall = draw_hall(3 * laps + 3, DAYS, faulty=round(3 * laps * FAULTY), places=PLACES, seed=7)
    first = 0
    for name, count in (("few", 3), ("single", laps), ("double", 2 * laps)):
        part = replace(hall, robots=hall.robots[first : first + count])
        write_store(part, folder / name, range(LAST, LAST + 1), 1, minutes)
        first += count


def spend(folder: Path, name: str, *, diagnosed: bool) -> tuple[int, int, Cost]:
    """Work on a store; return how many laps, how many of them with the whole diagnosis, and what it took."""
    results = folder / f"{name}-results"
    outcomes = []
    used = cost(
        lambda: outcomes.append(
            run_batch(str(folder / name), str(results), day=date_of(LAST), diagnosed=diagnosed)
        )
    )
    assert not outcomes[0].failed, outcomes[0].failed
    rows = (decode_columns(path.read_bytes()) for path in results.glob("recordings/*/*/*.parquet"))
    asked = sum(row["diagnosis"][0] is not None for row in rows)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3
    return outcomes[0].done, asked, used._replace(memory=memory)


def main() -> int:
    given = options(__doc__, laps=LAPS, minutes=5.0, no_diagnose=False)
    diagnosed = not given.no_diagnose
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        writer = multiprocessing.Process(target=write_laps, args=(folder, given.laps, given.minutes))
        writer.start()
        writer.join()
        spend(folder, "few", diagnosed=diagnosed)  # loads what is compiled
        batches, by_lap = [], []
        for name in ("single", "double"):
            laps, asked, spent = spend(folder, name, diagnosed=diagnosed)
            batches.append(spent)
            by_lap.append(spent.processor / laps)
            print(
                f"{laps} laps, {asked} whole diagnoses: {spent.processor:.0f} s of processor time "
                f"({by_lap[-1]:.2f} s for a lap), {spent.wall:.0f} s by the wall, "
                f"{spent.memory / 1e3:.2f} GB at most",
                flush=True,
            )
    single, double = batches
    day, memory = max(by_lap) * LAPS / CORES, double.memory / 1e3
    ratio = double.processor / single.processor
    print(f"twice the laps take {ratio:.2f} times the processor time")
    print(
        f"{LAPS} laps on {CORES} cores: {day / 60.0:.1f} minutes (wanted: {WANTED / 60.0:.0f}); "
        f"{memory:.2f} GB (wanted: below {MEMORY:.0f})"
    )
    return 0 if day <= WANTED and memory < MEMORY and ratio <= LINEAR else 1


if __name__ == "__main__":
    sys.exit(main())
