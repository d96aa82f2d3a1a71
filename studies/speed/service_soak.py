"""Whether memory, file handles or threads of the service grow under hours of use, and calls become slower.

Peer: the same service in the first half of the run; what grows is extrapolated from the second half.

Usage: python -m studies.speed.service_soak [--hours 0.25] [--interval 10] [--reads 20] [--posts 5]
       [--listeners 5] [--out soak]

`omnimate serve` runs with its simulated robot. Clients read, post samples, have the robot drive, upload and
delete recordings, have them diagnosed, and read the live stream. Clients break off: streams are left, and
uploads end in their middle, as the kernel ends the connections of a process that is killed. In the second
half the robot's process is killed regularly.

The folder `--out` gets `soak.csv`, a row for each interval, and `soak.png`. Slopes are those of Theil and
Sen (P. K. Sen, 1968: up to 29 % of the values may be anything) over the second half; for the robot's process,
over the second half of its longest life. Exit code 1 where the lower end of a slope's 95 % interval is beyond
the bound. A run of minutes cannot separate a leak from caches that fill; run it for hours.
"""

from __future__ import annotations

import asyncio
import csv
import itertools
import random
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Coroutine, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import httpx2
import numpy as np
import psutil
from scipy.stats import theilslopes

from omnimate.figures.style import BLUE, GREEN, GREY, ORANGE, VERMILLION
from omnimate.service.jobs.queue import ENDED_STATES
from omnimate.service.store.recordings import MEMORY_LIMIT
from studies.benchmark import options
from studies.figures import framed
from studies.speed.service_kill import DIAGNOSES, RUN, SESSIONS, ZIP, recording_zip
from studies.speed.service_load import RUNS, paced
from studies.speed.service_process import Service, serving

RECORDINGS, STREAM = "/v1/recordings", "/v1/robot/stream"
READS = ("/v1/robot", f"{SESSIONS}?limit=20", "/v1/vehicles/omnimate", "/metrics")
ROLES = ("service", "robot", "forkserver")  # processes that live as long as the service
PERIOD = 8 * 3600.0  # [s] for which growth is stated
MONTH = 90  # periods between two restarts of a service
# In a month it grows by no more than the memory of one upload [MB], and than the handles that a process may
# have (soft RLIMIT_NOFILE of Linux, 1024); threads as handles.
BOUNDS = {"memory": MEMORY_LIMIT / 1e6 / MONTH, "handles": 1024.0 / MONTH, "threads": 1024.0 / MONTH}
KILLS = 10  # of the robot's process, in the second half
KEPT = 20  # recordings, of which the oldest is deleted
JOB_PAUSE = 6  # intervals between the ends and begins of diagnoses, and between drives
Row = dict[str, float]


class Growth(NamedTuple):
    """Growth of a quantity in `PERIOD`, the lower end of its 95 % interval, and its bound."""

    name: str
    slope: float
    low: float
    bound: float

    @property
    def grows(self) -> bool:
        """Whether it grows beyond its bound, and not by the scatter of a short run."""
        return self.low > self.bound

    def __str__(self) -> str:
        word = "GROWS" if self.grows else "no growth shown"
        return f"{self.name}: {word}, {self.slope:+.1f} (from {self.low:+.1f}) in 8 h, bound {self.bound:.1f}"


def slope_of(seconds: Sequence[float], values: Sequence[float]) -> tuple[float, float]:
    """Return growth in `PERIOD` by the second half of the values, and the lower end of its 95 % interval.

    Both are 0 where that half has fewer than three values.
    """
    half = len(seconds) // 2
    if len(seconds) - half < 3:
        return 0.0, 0.0
    slope, _, low, _ = theilslopes(values[half:], seconds[half:], alpha=0.95)
    return float(slope) * PERIOD, float(low) * PERIOD


def judge(rows: Sequence[Row]) -> list[Growth]:
    """Return the growth of each quantity of each process."""
    lives = Counter(row["robot_pid"] for row in rows if row["robot_pid"])
    longest = lives.most_common(1)[0][0] if lives else 0.0
    growths = []
    for role, (quantity, bound) in itertools.product(ROLES, BOUNDS.items()):
        name = f"{role}_{quantity}"
        lived = [row for row in rows if role != "robot" or row["robot_pid"] == longest]
        slopes = slope_of([row["seconds"] for row in lived], [row[name] for row in lived])
        growths.append(Growth(name, *slopes, bound))
    return growths


def robot_of(forkserver: psutil.Process | None) -> psutil.Process | None:
    """Return the robot's process, once it runs: the only fork with unlimited memory and several threads."""
    children = [] if forkserver is None else forkserver.children()
    for child in children:
        with suppress(psutil.Error):
            limit, _ = child.rlimit(psutil.RLIMIT_DATA)
            if limit == psutil.RLIM_INFINITY and child.num_threads() > 1:
                return child
    return None


def forkserver_of(service: psutil.Process) -> psutil.Process | None:
    """Return the process from which all others of a service are forked."""
    for child in service.children():
        with suppress(psutil.Error):
            if "forkserver" in " ".join(child.cmdline()):
                return child
    return None


def measured(role: str, process: psutil.Process | None) -> Row:
    """Return resident memory [MB], open handles and threads of a process; zeros where it has just ended."""
    values: tuple[float, ...] = (0.0,) * len(BOUNDS)
    if process is not None:
        with suppress(psutil.Error), process.oneshot():
            values = process.memory_info().rss / 1e6, process.num_fds(), process.num_threads()
    return {f"{role}_{name}": float(value) for name, value in zip(BOUNDS, values, strict=True)}


def processes(root: psutil.Process) -> Row:
    """Return what the processes of a service take; `jobs` are all others together."""
    forkserver = forkserver_of(root)
    robot = robot_of(forkserver)
    row: Row = {"robot_pid": float(robot.pid if robot else 0)}
    for role, process in zip(ROLES, (root, robot, forkserver), strict=True):
        row |= measured(role, process)
    known = {process.pid for process in (root, robot, forkserver) if process is not None}
    others = [measured("jobs", child) for child in root.children(recursive=True) if child.pid not in known]
    return row | {f"jobs_{name}": sum(other[f"jobs_{name}"] for other in others) for name in BOUNDS}


def percentiles(kind: str, durations: Sequence[float]) -> Row:
    """Return the median and the 99th percentile of times [ms]."""
    p50, p99 = 1e3 * np.percentile(durations, [50, 99])
    return {f"{kind}_p50": float(p50), f"{kind}_p99": float(p99)}


@dataclass
class Load:
    """Clients of one service."""

    url: str
    recording: bytes
    interval: float
    chance: random.Random = field(default_factory=lambda: random.Random(0))
    # number of answers by call and status; 0 is a connection that broke
    answers: Counter[tuple[str, int]] = field(default_factory=Counter)
    events: int = 0  # `state` events that listeners got
    broken_off: int = 0
    http: httpx2.AsyncClient = field(init=False)

    def __post_init__(self) -> None:
        self.http = httpx2.AsyncClient(base_url=self.url, timeout=60.0)

    async def send(self, method: str, path: str, **content: Any) -> httpx2.Response | None:  # noqa: ANN401
        """Return the answer to a call, None where the connection broke; both are counted."""
        name = f"{method} {'/'.join(path.split('?', 1)[0].split('/')[:3])}"
        try:
            answer = await self.http.request(method, path, **content)
        except httpx2.TransportError:
            self.answers[name, 0] += 1
            return None
        self.answers[name, answer.status_code] += 1
        return answer

    async def read(self, index: int) -> None:
        """Make the next of the calls that change nothing."""
        await self.send("GET", READS[index % len(READS)])

    async def posts(self, rate: float) -> list[float]:
        """Post samples for an interval, to a session of its own; solve it, and return the times [s]."""
        count = -(-int(rate * self.interval) // RUNS)
        sessions = [await self.send("POST", SESSIONS, json={"side": 4.0}) for _ in range(count)]
        paths = [f"{SESSIONS}/{answer.json()['id']}" for answer in sessions if answer is not None]

        async def post(index: int) -> None:
            run = RUN | {"direction": ("cw", "ccw")[index % 2]}
            key = {"Idempotency-Key": f"{self.chance.getrandbits(64):x}"}
            await self.send("POST", f"{paths[index // RUNS]}/samples", json=run, headers=key)

        durations = await paced(rate, self.interval, post)
        for path in paths:
            await self.send("POST", f"{path}/solve")
        return durations

    async def listen(self) -> None:
        """Read the stream for a random time, leave it without a word, and begin again."""
        while True:
            end = time.monotonic() + self.chance.uniform(0.1, 2.0) * self.interval
            with suppress(httpx2.TransportError):
                async with self.http.stream("GET", STREAM) as answer:
                    async for block in answer.aiter_raw():
                        self.events += block.count(b"event: state")
                        if time.monotonic() > end:
                            break
            await asyncio.sleep(0.1)

    async def upload(self) -> None:
        """Upload recordings, and delete the oldest where there are many."""
        stored: list[str] = []
        while True:
            answer = await self.send("POST", f"{RECORDINGS}?name=soak", content=self.recording, headers=ZIP)
            if answer is not None and answer.status_code == 201:
                stored.append(answer.json()["id"])
            if len(stored) > KEPT:
                await self.send("DELETE", f"{RECORDINGS}/{stored.pop(0)}")
            await asyncio.sleep(self.interval)

    async def break_off(self) -> None:
        """Begin an upload, and abort the connection in its middle."""
        address = httpx2.URL(self.url)
        head = (
            f"POST {RECORDINGS} HTTP/1.1\r\nHost: {address.host}:{address.port}\r\n"
            f"Content-Type: application/zip\r\nContent-Length: {len(self.recording)}\r\n\r\n"
        )
        while True:
            with suppress(OSError):
                _, writer = await asyncio.open_connection(address.host, address.port)
                writer.write(head.encode() + self.recording[: len(self.recording) // 2])
                await writer.drain()
                writer.transport.abort()
                self.broken_off += 1
            await asyncio.sleep(self.chance.uniform(0.0, self.interval))

    async def diagnose(self) -> None:
        """Have recordings diagnosed, each under a new name: a known one gets its result at once."""
        for number in itertools.count():
            path = f"{RECORDINGS}?name=drive-{number}"
            stored = await self.send("POST", path, content=self.recording, headers=ZIP)
            if stored is not None and stored.status_code == 201:
                body = {"recordings": [stored.json()["id"]]}
                job = await self.send("POST", DIAGNOSES, json=body)
                while job is not None and job.json().get("state", "failed") not in ENDED_STATES:
                    await asyncio.sleep(self.interval / 2.0)
                    job = await self.send("GET", f"{DIAGNOSES}/{job.json()['id']}")
                await self.send("DELETE", f"{RECORDINGS}/{stored.json()['id']}")
            await asyncio.sleep(JOB_PAUSE * self.interval)

    async def drive(self) -> None:
        """Have the robot drive, and abort what it has not finished by the next time."""
        while True:
            answer = await self.send("POST", SESSIONS, json={"how": "drive", "side": 1.0})
            await asyncio.sleep(JOB_PAUSE * self.interval)
            if answer is not None and answer.status_code == 201:
                await self.send("POST", f"{SESSIONS}/{answer.json()['id']}/abort")

    async def kill_robots(self, service: psutil.Process, seconds: float) -> None:
        """Kill the robot's process regularly in the second half."""
        await asyncio.sleep(seconds / 2.0)
        while True:
            robot = robot_of(forkserver_of(service))
            if robot is not None:
                with suppress(psutil.NoSuchProcess):
                    robot.kill()
            await asyncio.sleep(seconds / (2.0 * KILLS))


async def soak(
    service: Service, load: Load, database: Path, seconds: float, rates: tuple[float, float], listeners: int
) -> list[Row]:
    """Return a row for each interval of a service under load, for some reads and posts a second (`rates`).

    The first row has all processes: robots are killed after it.
    """
    root, rows = psutil.Process(service.process.pid), list[Row]()
    while robot_of(forkserver_of(root)) is None:
        await asyncio.sleep(0.1)
    began = time.monotonic()
    others: list[Coroutine[None, None, None]] = [load.listen() for _ in range(listeners)]
    others += [load.upload(), load.break_off(), load.diagnose(), load.drive()]
    tasks = [asyncio.create_task(other) for other in others]
    try:
        while time.monotonic() - began < seconds:
            reads, posts = await asyncio.gather(
                paced(rates[0], load.interval, load.read), load.posts(rates[1])
            )
            for task in tasks:
                if task.done():
                    task.result()  # a client that failed is an error of this benchmark
            size = sum(path.stat().st_size for path in database.parent.glob(f"{database.name}*"))
            row = {"seconds": time.monotonic() - began} | processes(root) | {"database": size / 1e6}
            rows.append(row | percentiles("reads", reads) | percentiles("posts", posts))
            if len(rows) == 1:
                tasks.append(asyncio.create_task(load.kill_robots(root, seconds)))
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        await load.http.aclose()
    return rows


def trial(
    folder: Path,
    seconds: float,
    interval: float,
    rates: tuple[float, float] = (20.0, 5.0),
    listeners: int = 5,
) -> tuple[list[Row], Load]:
    """Return a row for each interval of a new service in a folder, and its clients' counts."""
    database = folder / "omnimate.db"  # as the service names it for a new user
    with serving(folder, f"sqlite:///{database}") as service:
        load = Load(service.url, recording_zip(folder), interval)
        return asyncio.run(soak(service, load, database, seconds, rates, listeners)), load


def write_csv(rows: Sequence[Row], path: Path) -> None:
    """Write the rows as a CSV file."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows({name: f"{value:.6g}" for name, value in row.items()} for row in rows)


def plot(rows: Sequence[Row], path: Path) -> None:
    """Draw memory, handles, threads, latencies and the database's size over time."""
    hours = [row["seconds"] / 3600.0 for row in rows]
    units = {"memory": "memory [MB]", "handles": "open handles", "threads": "threads"}
    with framed(path, (7.5, 11.0), 4) as figure:
        panels = figure.subplots(len(BOUNDS) + 2, sharex=True)
        for axes, quantity in zip(panels, BOUNDS, strict=False):
            for role, color, mark in zip(
                (*ROLES, "jobs"), (BLUE, VERMILLION, GREEN, GREY), "osv.", strict=True
            ):
                values = [row[f"{role}_{quantity}"] or np.nan for row in rows]
                axes.plot(hours, values, mark, color=color, markersize=3, label=role)
            axes.set(ylabel=units[quantity], ylim=(0.0, None))
        for kind, color in (("reads", BLUE), ("posts", ORANGE)):
            for part, line in (("p50", "-"), ("p99", ":")):
                values = [row[f"{kind}_{part}"] for row in rows]
                panels[-2].plot(hours, values, line, color=color, label=f"{kind} {part}")
        panels[-2].set(ylabel="time of a call [ms]", yscale="log")
        panels[-2].legend(ncols=4, loc="upper left", fontsize=8)
        panels[-1].plot(hours, [row["database"] for row in rows], color=BLUE)
        panels[-1].set(xlabel="time [h]", ylabel="database [MB]", ylim=(0.0, None))


def main() -> None:
    """Print what was measured; exit code 1 where something grows."""
    given = options(__doc__, hours=0.25, interval=10.0, reads=20.0, posts=5.0, listeners=5, out="soak")
    out = Path(given.out)
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        rates = given.reads, given.posts
        rows, load = trial(Path(folder), 3600.0 * given.hours, given.interval, rates, given.listeners)
    write_csv(rows, out / "soak.csv")
    plot(rows, out / "soak.png")
    kinds = [kind for kind in rows[0] if kind not in {"seconds", "robot_pid"}]
    print(f"{len(rows)} intervals; begin, middle, end:")
    for kind in kinds:
        print(f"  {kind:18s}", *(f"{rows[at][kind]:9.1f}" for at in (0, len(rows) // 2, -1)))
    for (call, status), count in sorted(load.answers.items()):
        print(f"{call}: {count} times {status or 'connection broken'}")
    print(f"{load.events} state events, {load.broken_off} uploads broken off")
    growths = judge(rows)
    print(*growths, sep="\n")
    sys.exit(any(growth.grows for growth in growths))


if __name__ == "__main__":
    main()
