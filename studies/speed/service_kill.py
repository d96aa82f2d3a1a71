"""What is lost when the service is killed at random moments under load.

Peer: what the clients were answered; every sample that was answered 201 must still be there.

Usage: python -m studies.speed.service_kill [--kills 200] [--database sqlite:///... or postgresql+psycopg://...]

Four clients start sessions and post samples, and one lets the robot drive. A random time after the first
promise the process gets SIGKILL, and a new process is asked for what the clients were promised.
"""

import random
import tempfile
import threading
import time
from dataclasses import dataclass, field
from pathlib import Path

import httpx2
from rich.progress import track

from studies.benchmark import options
from studies.speed.service_process import PATIENCE, Service

SESSIONS = "/v1/umbmark/sessions"
RUN = {"direction": "cw", "after": {"x": 0.1, "y": 0.02}, "calculated": {"x": 0.0, "y": 0.0}}
SETTLED = {"collecting", "interrupted", "aborted", "failed", "solved", "accepted"}


@dataclass
class Promised:
    """What clients were answered 201 or 200, by session; `first` is set with the first sample."""

    samples: dict[str, set[int]] = field(default_factory=dict)
    first: threading.Event = field(default_factory=threading.Event)
    solved: dict[str, str] = field(default_factory=dict)
    driven: set[str] = field(default_factory=set)
    lock: threading.Lock = field(default_factory=threading.Lock)


def load(url: str, promised: Promised, seed: int) -> None:
    """Be a client until the service is gone."""
    chance = random.Random(seed)
    try:
        with httpx2.Client(base_url=url, timeout=20.0) as client:
            while True:
                session = client.post(SESSIONS, json={"side": 4.0}).raise_for_status().json()["id"]
                with promised.lock:
                    promised.samples[session] = set()
                for number in range(chance.randint(1, 12)):
                    run = RUN | {"direction": ("cw", "ccw")[number % 2]}
                    made = client.post(f"{SESSIONS}/{session}/samples", json=run).raise_for_status()
                    with promised.lock:
                        promised.samples[session].add(made.json()["number"])
                        promised.first.set()
                if number >= 1:
                    solved = client.post(f"{SESSIONS}/{session}/solve").raise_for_status()
                    with promised.lock:
                        promised.solved[session] = solved.json()["revision"]
    except (httpx2.TransportError, httpx2.HTTPStatusError):
        return


def drive(url: str, promised: Promised) -> None:
    """Let the robot drive until the service is gone."""
    try:
        with httpx2.Client(base_url=url, timeout=20.0) as client:
            answer = client.post(SESSIONS, json={"how": "drive", "side": 1.0, "runs": 5})
            if answer.status_code == 201:
                with promised.lock:
                    promised.driven.add(answer.json()["id"])
    except httpx2.TransportError:
        return


def lost(url: str, promised: Promised) -> list[str]:
    """Return a sentence for everything that was promised and is not there."""
    missing = []
    with httpx2.Client(base_url=url, timeout=60.0) as client:
        for session, numbers in promised.samples.items():
            answer = client.get(f"{SESSIONS}/{session}")
            if answer.status_code != 200:
                missing.append(f"session {session} is gone")
                continue
            there = {sample["number"] for sample in answer.json()["samples"]}
            missing += [f"session {session}: sample {number} is gone" for number in numbers - there]
            result = client.get(f"{SESSIONS}/{session}/result")
            if session in promised.solved and result.json().get("revision") != promised.solved[session]:
                missing.append(f"session {session}: its result is gone")
    return missing


def stuck(url: str, promised: Promised) -> set[str]:
    """Return sessions that are still being driven when the leases of a dead process have run out."""
    end = time.monotonic() + PATIENCE
    waiting = set(promised.driven)
    with httpx2.Client(base_url=url, timeout=60.0) as client:
        while waiting and time.monotonic() < end:
            waiting = {
                session
                for session in waiting
                if client.get(f"{SESSIONS}/{session}").json()["state"] not in SETTLED
            }
            time.sleep(0.5)
    return waiting


def trial(folder: Path | str, database: str, kills: int, seed: int = 0) -> tuple[int, list[str], set[str]]:
    """Return (samples promised, what was lost, sessions stuck) after so many kills."""
    chance = random.Random(seed)
    promised, missing, promises, everything = Promised(), [], 0, Promised()
    for number in track(range(kills), "killing"):
        service = Service(folder, database)
        missing += lost(service.url, promised)
        promises += sum(len(numbers) for numbers in promised.samples.values())
        everything.driven |= promised.driven
        promised = Promised()
        clients = [
            threading.Thread(target=load, args=(service.url, promised, 10 * number + client))
            for client in range(4)
        ]
        clients.append(threading.Thread(target=drive, args=(service.url, promised)))
        for client in clients:
            client.start()
        promised.first.wait(PATIENCE)
        time.sleep(chance.uniform(0.0, 2.0))
        service.kill()
        for client in clients:
            client.join()
    service = Service(folder, database)
    missing += lost(service.url, promised)
    promises += sum(len(numbers) for numbers in promised.samples.values())
    everything.driven |= promised.driven
    left = stuck(service.url, everything)
    service.stop()
    return promises, missing, left


def main() -> None:
    """Print what was lost."""
    given = options(__doc__, kills=200, database=None)
    with tempfile.TemporaryDirectory() as folder:
        database = given.database or f"sqlite:///{folder}/service.db"
        promises, missing, left = trial(folder, database, given.kills)
    kind = database.partition(":")[0]
    print(f"{kind}: {given.kills} kills, {promises} samples answered 201")
    print(f"{len(missing)} lost, {len(left)} sessions stuck")
    for line in [*missing, *left]:
        print(f"  {line}")


if __name__ == "__main__":
    main()
