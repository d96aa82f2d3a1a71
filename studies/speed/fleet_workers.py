"""How much faster two workers of Dask are than one: `omnimate fleet run` on the same laps.

Processor time counts, because the machine may be shared: what all workers and the scheduler use together,
and how evenly the workers share it. With a core for each worker, the wall is that of the busier one.

Peer, in the same run: one worker.

Usage: python -m studies.speed.fleet_workers [--robots 24] [--minutes 5]
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path

import distributed

from omnimate.fleet.batch.run import Workers, run_batch
from omnimate.fleet.hall.hall import draw_hall, write_store
from studies.benchmark import options

WANTED = 1.9  # times as fast


def spent(store: Path, workers: int) -> tuple[list[float], float, float]:
    """Return the processor time of each worker, of the scheduler, and the wall [s], of a day's batch."""
    with (
        tempfile.TemporaryDirectory() as results,
        distributed.LocalCluster(
            n_workers=workers, threads_per_worker=1, processes=True, dashboard_address="127.0.0.1:0"
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        crew = Workers(scheduler=cluster.scheduler_address)
        run_batch(str(store), results, day="2026-03-02", diagnosed=False, workers=crew)  # compiles
        before, ours, wall = client.run(time.process_time), time.process_time(), time.perf_counter()
        run_batch(str(store), results, day="2026-03-03", diagnosed=False, workers=crew)
        wall = time.perf_counter() - wall
        after = client.run(time.process_time)
        return [after[name] - before[name] for name in after], time.process_time() - ours, wall


def main() -> int:
    given = options(__doc__, robots=24, minutes=5.0)
    hall = draw_hall(given.robots, 5, faulty=0, places=3, seed=7)
    with tempfile.TemporaryDirectory() as place:
        store = Path(place) / "store"
        write_store(hall, store, range(2), 1, given.minutes)
        times = {}
        for workers in (1, 2):
            of_task, scheduler, wall = spent(store, workers)
            times[workers] = max(of_task)
            shown = " and ".join(f"{seconds:.1f}" for seconds in of_task)
            print(
                f"{workers} worker(s), {given.robots} laps: {shown} s of processor time, "
                f"scheduler {scheduler:.1f} s, wall {wall:.1f} s"
            )
    ratio = times[1] / times[2]
    print(f"two are {ratio:.2f} times as fast, by the processor time of the busier (wanted: {WANTED})")
    return 0 if ratio >= WANTED else 1


if __name__ == "__main__":
    sys.exit(main())
