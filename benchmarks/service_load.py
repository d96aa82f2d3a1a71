"""The service under load, from a second process: how long reads and sample posts take while a bus is tracked.

    python -m benchmarks.service_load [--seconds 20] [--reads 200] [--posts 50] [--listeners 50]

Calls leave at fixed times whether or not the ones before them have been answered, and its duration counts
from when it should have left, so that a slow answer is not hidden by the wait for it.
"""

import argparse
import asyncio
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import httpx2
import numpy as np

from benchmarks.service_process import serving
from vcan_sim.reference import reference_vehicle
from vehicle.file import save_vehicle

SESSIONS = "/v1/umbmark/sessions"
RUN = {"direction": "cw", "after": {"x": 0.1, "y": 0.02}, "calculated": {"x": 0.0, "y": 0.0}}
WARM = 5.0  # [s] that do not count: the tracker is loaded in them
RUNS = 900  # of one session


async def paced(rate: float, seconds: float, call) -> list[float]:  # noqa: ANN001  # of an index
    """Make calls at a rate [1/s]; return how long each took from when it should have left [s]."""
    began, durations, tasks = time.perf_counter(), [], []

    async def one(index: int, due: float) -> None:
        await call(index)
        durations.append(time.perf_counter() - due)

    for index in range(int(rate * seconds)):
        due = began + index / rate
        await asyncio.sleep(max(0.0, due - time.perf_counter()))
        tasks.append(asyncio.create_task(one(index, due)))
    await asyncio.gather(*tasks)
    return durations


async def listen(url: str, seconds: float) -> int:
    """Read the stream for so long; return how many `state` events came."""
    seen, end = 0, time.perf_counter() + seconds
    async with (
        httpx2.AsyncClient(base_url=url, timeout=30.0) as client,
        client.stream("GET", "/v1/robot/stream") as stream,
    ):
        async for line in stream.aiter_lines():
            seen += line == "event: state"
            if time.perf_counter() > end:
                return seen
    return seen


async def measure(url: str, options: argparse.Namespace) -> tuple[list[float], list[float], list[int]]:
    """Return the durations of reads and posts, and the events that each listener got."""
    limits = httpx2.Limits(max_connections=100, max_keepalive_connections=100)
    async with httpx2.AsyncClient(base_url=url, timeout=30.0, limits=limits) as client:
        sessions = [
            (await client.post(SESSIONS, json={"side": 4.0})).json()["id"]
            for _ in range(1 + int(options.posts * options.seconds) // RUNS)
        ]

        async def read(index: int) -> None:
            path = ("/v1/robot", f"{SESSIONS}?limit=20", "/v1/vehicles/omnimate", "/v1/bus")[index % 4]
            (await client.get(path)).raise_for_status()

        async def post(index: int) -> None:
            path = f"{SESSIONS}/{sessions[index // RUNS]}/samples"
            (await client.post(path, json=RUN)).raise_for_status()

        reads, posts, *events = await asyncio.gather(
            paced(options.reads, options.seconds, read),
            paced(options.posts, options.seconds, post),
            *(listen(url, options.seconds) for _ in range(options.listeners)),
        )
    return reads, posts, events


def listing(url: str) -> list[float]:
    """Return how long pages of the sessions' list take [s]."""
    with httpx2.Client(base_url=url, timeout=60.0) as client:
        durations, after = [], None
        for _ in range(100):
            began = time.perf_counter()
            page = client.get(SESSIONS, params={"limit": 50} | ({"after": after} if after else {})).json()
            durations.append(time.perf_counter() - began)
            after = page["next"]
    return durations


def fill(database: str, count: int) -> None:
    """Store sessions, as years of use would."""
    from service.store.database import Database
    from service.umbmark import sessions
    from service.umbmark.models import SessionStart

    store = Database(database)
    with store.writing() as db:
        for _ in range(count):
            sessions.start(db, SessionStart(side=4.0), "omnimate", 1e6)
    store.close()


def words(durations: list[float]) -> str:
    """Return the distribution in milliseconds."""
    p50, p99, worst = 1e3 * np.percentile(durations, [50, 99, 100])
    return f"p50 {p50:.1f} ms, p99 {p99:.1f} ms, worst {worst:.1f} ms, of {len(durations)}"


def main() -> None:
    """Print what was measured."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--bus-rate", type=float, default=100.0)
    parser.add_argument("--reads", type=float, default=200.0)
    parser.add_argument("--posts", type=float, default=50.0)
    parser.add_argument("--listeners", type=int, default=50)
    parser.add_argument("--stored", type=int, default=10_000)
    parser.add_argument("--database")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        database = options.database or f"sqlite:///{folder}/service.db"
        vehicle = reference_vehicle()
        bus = replace(vehicle.bus, sync_period=1.0 / options.bus_rate)
        save_vehicle(replace(vehicle, bus=bus), Path(folder) / "vehicle.toml")
        with serving(folder, database, "--vehicle", "vehicle.toml") as service:
            print(f"{database.partition(':')[0]}: ready after {service.ready:.2f} s")
            time.sleep(WARM)
            before = httpx2.get(f"{service.url}/v1/robot").json()
            began = time.perf_counter()
            reads, posts, events = asyncio.run(measure(service.url, options))
            passed, after = time.perf_counter() - began, httpx2.get(f"{service.url}/v1/robot").json()
            fill(database, options.stored)
            pages = listing(service.url)
    expected = passed * options.bus_rate
    print(f"reads at {options.reads:g}/s: {words(reads)}")
    print(f"posts at {options.posts:g}/s: {words(posts)}")
    if events:
        print(
            f"{len(events)} listeners: {min(events)} to {max(events)} state events in {options.seconds:g} s"
        )
    print(
        f"bus at {options.bus_rate:g} Hz: {after['samples'] - before['samples']} of {expected:.0f} samples, "
        f"{after['incomplete'] - before['incomplete']} incomplete"
    )
    print(f"listing with {options.stored} sessions stored: {words(pages)}")


if __name__ == "__main__":
    main()
