"""The times of the service's answers under load, measured from a second process, while it tracks a bus.

Peer: `/healthz` at the same rate without other load, which does nothing but answer.

Usage: python -m studies.speed.service_load [--seconds 20] [--reads 200] [--posts 50] [--listeners 50]

Calls leave at fixed times, whether or not earlier calls have been answered. The duration of a call counts
from when it should have left, so that a slow answer is not hidden by the wait for it.

The robot is simulated in a process of its own, which stamps each SYNC of the service when it arrives. A SYNC
is late by what its distance from the one before it exceeds the period.
"""

import argparse
import asyncio
import json
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import httpx2
import numpy as np

from omnimate.files.logs.blocks import read_log
from omnimate.vcan_sim.nodes.device import SYNC_ID
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vehicle.file import save_vehicle
from studies.benchmark import OMNIMATE, options
from studies.speed.service_process import serving

SESSIONS = "/v1/umbmark/sessions"
RUN = {"direction": "cw", "after": {"x": 0.1, "y": 0.02}, "calculated": {"x": 0.0, "y": 0.0}}
IDLE = 3.0  # [s] of calls without other load
WARM = 5.0  # [s] that do not count: the tracker is loaded in them
RUNS = 900  # of one session


async def paced(rate: float, seconds: float, call: Callable[[int], Awaitable[object]]) -> list[float]:
    """Make calls at a rate [1/s]; return how long each took from when it should have left [s]."""
    began, durations, tasks = time.perf_counter(), [], []

    async def timed(index: int, due: float) -> None:
        await call(index)
        durations.append(time.perf_counter() - due)

    for index in range(int(rate * seconds)):
        due = began + index / rate
        await asyncio.sleep(max(0.0, due - time.perf_counter()))
        tasks.append(asyncio.create_task(timed(index, due)))
    await asyncio.gather(*tasks)
    return durations


class Client:
    """Keep-alive connections that cost little: on two cores a load that computes would measure itself."""

    def __init__(self, url: str) -> None:
        _, self.host, port = url.replace("//", "").split(":")
        self.port = int(port)
        self._idle: list[tuple[asyncio.StreamReader, asyncio.StreamWriter]] = []

    async def call(self, method: str, path: str, body: bytes = b"") -> bytes:
        """Make a call; return what it is answered with, where that is a success."""
        reader, writer = (
            self._idle.pop() if self._idle else await asyncio.open_connection(self.host, self.port)
        )
        writer.write(self._request(method, path, body))
        head = await reader.readuntil(b"\r\n\r\n")
        length = re.search(rb"content-length: (\d+)", head)
        assert length is not None, head
        content = await reader.readexactly(int(length[1]))
        if head.split(None, 2)[1] not in {b"200", b"201"}:
            raise RuntimeError(f"{method} {path}: {content.decode()}")
        self._idle.append((reader, writer))
        return content

    async def listen(self, everybody: asyncio.Barrier, seconds: float) -> int:
        """Read the stream for so long once everybody listens; return how many `state` events came."""
        reader, writer = await asyncio.open_connection(self.host, self.port)
        writer.write(self._request("GET", "/v1/robot/stream", b""))
        await reader.readuntil(b"event: state")
        await everybody.wait()
        seen, end = 0, time.perf_counter() + seconds
        while time.perf_counter() < end:
            seen += (await reader.read(65536)).count(b"event: state")
        writer.close()
        return seen

    def _request(self, method: str, path: str, body: bytes) -> bytes:
        return (
            f"{method} {path} HTTP/1.1\r\nHost: {self.host}:{self.port}\r\n"
            f"Content-Type: application/json\r\nContent-Length: {len(body)}\r\n\r\n"
        ).encode() + body


async def idle(url: str, rate: float) -> list[float]:
    """Return the durations of calls that ask for nothing."""
    client = Client(url)

    async def live(_index: int) -> None:
        await client.call("GET", "/healthz")

    return await paced(rate, IDLE, live)


async def measure(url: str, given: argparse.Namespace) -> tuple[list[float], list[float], list[int]]:
    """Return the durations of reads and posts, and the events that each listener got."""
    client, run = Client(url), json.dumps(RUN).encode()
    sessions = [
        json.loads(await client.call("POST", SESSIONS, b'{"side": 4.0}'))["id"]
        for _ in range(1 + int(given.posts * given.seconds) // RUNS)
    ]

    async def read(index: int) -> None:
        await client.call(
            "GET", ("/v1/robot", f"{SESSIONS}?limit=20", "/v1/vehicles/omnimate", "/v1/bus")[index % 4]
        )

    async def post(index: int) -> None:
        await client.call("POST", f"{SESSIONS}/{sessions[index // RUNS]}/samples", run)

    everybody = asyncio.Barrier(given.listeners + 1)
    listeners = asyncio.gather(*(client.listen(everybody, given.seconds) for _ in range(given.listeners)))
    await everybody.wait()
    reads, posts, events = await asyncio.gather(
        paced(given.reads, given.seconds, read), paced(given.posts, given.seconds, post), listeners
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
    from omnimate.service.store.database import Database
    from omnimate.service.umbmark.models import SessionStart
    from omnimate.service.umbmark.sessions import start_session

    store = Database(database)
    with store.writing() as db:
        for _ in range(count):
            start_session(db, SessionStart(side=4.0), "omnimate", 1e6)
    store.close()


@contextmanager
def simulated(folder: Path | str) -> Iterator[str]:
    """Yield the URL of a simulated robot's bus in another process."""
    command = [*OMNIMATE, "sim", "--listen", "127.0.0.1:0", "--vehicle", "vehicle.toml"]
    with subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None  # a pipe
            listening = re.search(r"listening on ([\d.:]+)", process.stdout.readline())
            assert listening is not None, "the simulated robot did not start"
            yield f"socketcand://{listening[1]}/can0"
        finally:
            process.terminate()


@contextmanager
def logged(bus: str, log: Path) -> Iterator[None]:
    _, host, port, channel = re.split("[:/]+", bus)
    command = [
        sys.executable, "-m", "can.logger", "-i", "socketcand", "-c", channel, "-f", str(log),
        "--filter", f"{SYNC_ID:x}:7ff", "--bus-kwargs", f"host={host}", f"port={port}",
    ]  # fmt: skip
    with subprocess.Popen(command, stdout=subprocess.DEVNULL) as process:
        try:
            yield
        finally:
            process.send_signal(signal.SIGINT)


def lateness(log: Path, period: float) -> list[float]:
    """Return by how much each SYNC came later than a period after the one before it [s]."""
    return list(np.maximum(np.diff(read_log(log).frames.time) - period, 0.0))


def words(durations: list[float]) -> str:
    p50, p99, worst = 1e3 * np.percentile(durations, [50, 99, 100])
    return f"p50 {p50:.1f} ms, p99 {p99:.1f} ms, worst {worst:.1f} ms, of {len(durations)}"


def main() -> None:
    given = options(
        __doc__,
        seconds=20.0,
        bus_rate=100.0,
        reads=200.0,
        posts=50.0,
        listeners=50,
        stored=10_000,
        database=None,
    )
    with tempfile.TemporaryDirectory() as folder:
        database = given.database or f"sqlite:///{folder}/service.db"
        vehicle = reference_vehicle()
        bus = replace(vehicle.bus, sync_period=1.0 / given.bus_rate)
        save_vehicle(replace(vehicle, bus=bus), Path(folder) / "vehicle.toml")
        log = Path(folder) / "sync.log"
        with (
            simulated(folder) as robot,
            serving(folder, database, "--vehicle", "vehicle.toml", "--bus", robot) as service,
        ):
            print(f"{database.partition(':')[0]}: ready after {service.ready:.2f} s")
            time.sleep(WARM)
            unloaded = asyncio.run(idle(service.url, given.reads))
            before = httpx2.get(f"{service.url}/v1/robot").json()
            began = time.perf_counter()
            with logged(robot, log):
                reads, posts, events = asyncio.run(measure(service.url, given))
            passed, after = time.perf_counter() - began, httpx2.get(f"{service.url}/v1/robot").json()
            fill(database, given.stored)
            pages = listing(service.url)
        late = lateness(log, bus.sync_period)
    expected = passed * given.bus_rate
    print(f"/healthz at {given.reads:g}/s, no other load: {words(unloaded)}")
    print(f"reads at {given.reads:g}/s: {words(reads)}")
    print(f"posts at {given.posts:g}/s: {words(posts)}")
    if events:
        print(f"{len(events)} listeners: {min(events)} to {max(events)} state events in {given.seconds:g} s")
    print(
        f"bus at {given.bus_rate:g} Hz: {after['samples'] - before['samples']} of {expected:.0f} samples, "
        f"{after['incomplete'] - before['incomplete']} incomplete"
    )
    print(f"SYNC late by: {words(late)}")
    print(f"listing with {given.stored} sessions stored: {words(pages)}")


if __name__ == "__main__":
    main()
