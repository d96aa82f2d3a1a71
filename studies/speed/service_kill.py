"""What is lost when services on one database are killed at random moments under load.

Peer: what the clients were answered; every change that was acknowledged must be there, once.

Usage: python -m studies.speed.service_kill [--kills 200] [--services 1]
       [--database sqlite:///... or postgresql+psycopg://...]

Four clients call a random service with an Idempotency-Key, and repeat the call with the same key until one
answers: they start sessions, post samples, solve, accept the result twice at once, increment a number in a
vehicle file with If-Match, and have the robot drive and a recording diagnosed. A random time after an
acknowledged sample one process gets SIGKILL and is started again. PostgreSQL needs a new database.
"""

import random
import re
import secrets
import tempfile
import threading
import time
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import httpx2
from rich.progress import track

from omnimate.files.recordings.folder import save_recording
from omnimate.files.recordings.zipped import pack
from omnimate.motion.paths import umbmark
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth
from omnimate.vehicle.file import format_vehicle
from studies.benchmark import options
from studies.speed.service_process import PATIENCE, Service

SESSIONS, VEHICLES, DIAGNOSES = "/v1/umbmark/sessions", "/v1/vehicles", "/v1/diagnoses"
RUN = {"after": {"x": 0.1, "y": 0.02}, "calculated": {"x": 0.0, "y": 0.0}}
ZIP = {"Content-Type": "application/zip"}
CLIENTS = 4
SETTLED = {"collecting", "interrupted", "aborted", "failed", "solved", "accepted", "done", "cancelled"}


@dataclass
class Acknowledged:
    """What clients were answered."""

    samples: dict[str, list[int]] = field(default_factory=dict)  # numbers of the samples, by session
    accepted: dict[str, list[int]] = field(default_factory=dict)  # versions that accepts of a session made
    increments: int = 0  # how often the number in the counter's vehicle file was incremented
    waiting: set[str] = field(default_factory=set)  # paths of driven sessions and jobs, which have to end
    problems: list[str] = field(default_factory=list)  # answers that no client should get
    unavailable: int = 0  # answers 503 with Retry-After
    sampled: threading.Event = field(default_factory=threading.Event)  # set with each sample
    ending: threading.Event = field(default_factory=threading.Event)  # set when the clients shall end
    lock: threading.Lock = field(default_factory=threading.Lock)


class Client:
    """A client of all services, which repeats a call until one of them answers."""

    def __init__(self, services: list[Service], acknowledged: Acknowledged, seed: int) -> None:
        self.services, self.acknowledged, self.chance = services, acknowledged, random.Random(seed)
        self.http = httpx2.Client(timeout=30.0)

    def send(
        self,
        method: str,
        path: str,
        *expected: int,
        headers: Mapping[str, str] | None = None,
        **body: Any,  # noqa: ANN401  # `json` or `content` of httpx
    ) -> httpx2.Response:
        """Return the first answer other than 503; an unexpected one is a problem."""
        headers = {"Idempotency-Key": secrets.token_hex(8), **(headers or {})}
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            url = self.chance.choice(self.services).url
            try:
                answer = self.http.request(method, f"{url}{path}", headers=headers, **body)
            except httpx2.TransportError:
                time.sleep(0.02)
                continue
            if answer.status_code == 503 and "Retry-After" in answer.headers and 503 not in expected:
                with self.acknowledged.lock:
                    self.acknowledged.unavailable += 1
                time.sleep(0.1)
                continue
            if answer.status_code not in (expected or {200, 201, 202}):
                with self.acknowledged.lock:
                    self.acknowledged.problems.append(f"{method} {path}: {answer.status_code} {answer.text}")
            return answer
        raise RuntimeError(f"no service answered {method} {path} within {PATIENCE:g} s")

    def run(self, recording: str) -> None:
        """Calibrate, increment, drive and diagnose until the clients shall end."""
        while not self.acknowledged.ending.is_set():
            self.calibrate()
            self.increment()
            if self.chance.random() < 0.3:
                self.wait_for(SESSIONS, {"how": "drive", "side": 1.0}, 201, 409, 503)
            if not any(path.startswith(DIAGNOSES) for path in tuple(self.acknowledged.waiting)):
                self.wait_for(DIAGNOSES, {"recordings": [recording]}, 202)

    def calibrate(self) -> None:
        """Post samples of a new session, solve it, and accept the result twice at once."""
        acknowledged = self.acknowledged
        session = self.send("POST", SESSIONS, json={"side": 4.0}).json()["id"]
        path = f"{SESSIONS}/{session}"
        numbers = acknowledged.samples.setdefault(session, [])
        for count in range(self.chance.randint(2, 8)):
            run = RUN | {"direction": ("cw", "ccw")[count % 2]}
            numbers.append(self.send("POST", f"{path}/samples", json=run).json()["number"])
            acknowledged.sampled.set()
        revision = self.send("POST", f"{path}/solve").headers["ETag"]

        def accept(_: int) -> httpx2.Response:
            headers = {"If-Match": revision}
            return self.send("POST", f"{path}/accept", 200, 409, 412, json={"force": True}, headers=headers)

        with ThreadPoolExecutor(2) as pool:
            answers = list(pool.map(accept, range(2)))
        acknowledged.accepted[session] = [
            int(answer.headers["ETag"].strip('"')) for answer in answers if answer.status_code == 200
        ]

    def increment(self) -> None:
        """Increment the number in the counter's file, unless another client is faster."""
        seen = self.send("GET", f"{VEHICLES}/counter")
        headers = {"If-Match": seen.headers["ETag"], "Content-Type": "application/toml"}
        text = counter_text(count_in(seen) + 1)
        answer = self.send("PUT", f"{VEHICLES}/counter", 200, 412, content=text, headers=headers)
        if answer.status_code == 200:
            with self.acknowledged.lock:
                self.acknowledged.increments += 1

    def wait_for(self, path: str, body: Mapping[str, object], *expected: int) -> None:
        """Start a driven session or a job, which has to end."""
        answer = self.send("POST", path, *expected, json=body)
        if answer.status_code in {201, 202}:
            with self.acknowledged.lock:
                self.acknowledged.waiting.add(f"{path}/{answer.json()['id']}")


def counter_text(count: int) -> str:
    """Return the file of a vehicle with a number in it."""
    text = format_vehicle(reference_vehicle()).replace('"omnimate"', '"counter"', 1)
    return f"{text}\n# count {count}\n"


def count_in(answer: httpx2.Response) -> int:
    """Return the number in a vehicle's file."""
    count = re.search(r"# count (\d+)", answer.json()["toml"])
    assert count is not None, answer.text
    return int(count[1])


def differences(client: Client) -> list[str]:
    """Return a sentence for everything that is not as it was acknowledged."""
    acknowledged, differing = client.acknowledged, []
    for session, numbers in acknowledged.samples.items():
        stored = client.send("GET", f"{SESSIONS}/{session}").json()["samples"]
        if [sample["number"] for sample in stored] != numbers:
            differing.append(f"session {session}: acknowledged {numbers}, stored {len(stored)}")
    versions = client.send("GET", f"{VEHICLES}/omnimate/versions").json()
    stored = {row["version"]: row["origin"] for row in versions}
    if sorted(stored) != list(range(1, len(versions) + 1)):
        differing.append(f"versions are missing: {sorted(stored)}")
    made = {
        version: f"session {session}" for session, them in acknowledged.accepted.items() for version in them
    }
    if len(made) != sum(map(len, acknowledged.accepted.values())):
        differing.append("double accept: two were answered with one version")
    differing += [
        f"double accept of {session}" for session, made in acknowledged.accepted.items() if len(made) > 1
    ]
    if made != {version: origin for version, origin in stored.items() if origin != "file"}:
        differing.append(f"accepts acknowledged {len(made)}, versions stored {len(stored) - 1}")
    counter = client.send("GET", f"{VEHICLES}/counter")
    if not count_in(counter) == counter.json()["version"] - 1 == acknowledged.increments:
        differing.append(
            f"lost update: {count_in(counter)} of {acknowledged.increments} increments are there"
        )
    return differing


def stuck(client: Client) -> set[str]:
    """Return driven sessions and jobs that have not ended when the leases of dead processes have run out."""
    end = time.monotonic() + PATIENCE
    waiting = client.acknowledged.waiting
    while waiting and time.monotonic() < end:
        waiting = {path for path in waiting if client.send("GET", path).json()["state"] not in SETTLED}
        time.sleep(0.5)
    return waiting


def recording_zip(folder: Path | str) -> bytes:
    vehicle = reference_vehicle()
    assert vehicle.linkage is not None  # two trucks
    program = umbmark(0.5, 1, speed=0.4, link_length=vehicle.linkage.length)
    save_recording(simulate(vehicle, Truth(vehicle, seed=3), program), Path(folder) / "recording")
    return pack(Path(folder) / "recording")


def trial(
    folder: Path | str, database: str, kills: int, count: int = 1, seed: int = 0
) -> tuple[Acknowledged, list[str], set[str]]:
    """Return (what was acknowledged, what differs from it, sessions and jobs stuck) after so many kills."""
    chance, acknowledged = random.Random(seed), Acknowledged()
    services = [Service(folder, database) for _ in range(count)]
    clients = [Client(services, acknowledged, 100 * seed + number) for number in range(CLIENTS)]
    try:
        _load_and_kill(folder, database, clients, kills, chance)
        return acknowledged, acknowledged.problems + differences(clients[0]), stuck(clients[0])
    finally:
        for client in clients:
            client.http.close()
        for service in services:
            service.stop()


def _load_and_kill(
    folder: Path | str, database: str, clients: list[Client], kills: int, chance: random.Random
) -> None:
    """Let clients call their services, of which one after the other is killed and started again."""
    services, acknowledged = clients[0].services, clients[0].acknowledged
    toml = {"Content-Type": "application/toml"}
    clients[0].send("POST", VEHICLES, 201, content=counter_text(0), headers=toml)
    stored = clients[0].send("POST", "/v1/recordings", content=recording_zip(folder), headers=ZIP)
    recording = stored.json()["id"]
    with ThreadPoolExecutor(CLIENTS) as pool:
        try:
            running = [pool.submit(client.run, recording) for client in clients]
            for _ in track(range(kills), "killing"):
                acknowledged.sampled.clear()
                acknowledged.sampled.wait(PATIENCE)
                time.sleep(chance.uniform(0.0, 2.0))
                victim = chance.randrange(len(services))
                services[victim].kill()
                services[victim] = Service(folder, database)
        finally:
            acknowledged.ending.set()
        for client in running:
            client.result()


def main() -> None:
    given = options(__doc__, kills=200, services=1, database=None)
    with tempfile.TemporaryDirectory() as folder:
        database = given.database or f"sqlite:///{folder}/service.db"
        acknowledged, differing, left = trial(folder, database, given.kills, given.services)
    print(f"{database.partition(':')[0]}: {given.services} services, {given.kills} kills")
    print(
        f"acknowledged: {sum(map(len, acknowledged.samples.values()))} samples, "
        f"{sum(map(len, acknowledged.accepted.values()))} accepts of {2 * len(acknowledged.accepted)}, "
        f"{acknowledged.increments} increments, {len(acknowledged.waiting)} drives and jobs"
    )
    print(
        f"{acknowledged.unavailable} answers 503, {len(differing)} lost, double or wrong, {len(left)} stuck"
    )
    for line in [*differing, *left]:
        print(f"  {line}")


if __name__ == "__main__":
    main()
