"""Takes one queued diagnosis after the other; what died with its service is taken up again."""

from __future__ import annotations

import json
import logging
import multiprocessing
import secrets
import tempfile
import threading
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sqlalchemy import delete, select, update
from sqlalchemy.exc import SQLAlchemyError

from service.errors import NotThereError, StateError
from service.jobs.child import run
from service.jobs.models import Job
from service.recordings import unpack
from service.robot.desk import interrupt_orphans
from service.store.tables import AnswerRow, JobRow, RecordingRow, SessionRow
from service.umbmark.states import OPEN

if TYPE_CHECKING:
    from collections.abc import Sequence
    from multiprocessing.connection import Connection
    from multiprocessing.process import BaseProcess

    from sqlalchemy import Delete, Update
    from sqlalchemy.orm import Session

    from service.hub import Hub
    from service.robot.desk import Desk
    from service.store.database import Database

LEASE, LOOK, TOLD = 20.0, 1.0, 0.5  # [s] of a lease, between two looks, between two events of progress
ATTEMPTS = 3
REMEMBERED = 86400.0  # [s] in which a call with an Idempotency-Key may be repeated
ENDED = ("done", "failed", "cancelled")
_log = logging.getLogger(__name__)


def add_job(db: Session, recordings: Sequence[str]) -> JobRow:
    """Queue a diagnosis of recordings.

    Raises:
        NotThereError: one of them is not there.
    """
    for one in recordings:
        if db.get(RecordingRow, one) is None:
            raise NotThereError("recording", one)
    now = time.time()
    row = JobRow(
        id=secrets.token_hex(8),
        recordings=json.dumps(list(recordings)),
        state="queued",
        progress=0.0,
        doing="waiting",
        attempts=0,
        created=now,
        changed=now,
    )
    db.add(row)
    return row


def job(db: Session, name: str) -> JobRow:
    """Return a job.

    Raises:
        NotThereError: there is none of this id.
    """
    row = db.get(JobRow, name)
    if row is None:
        raise NotThereError("diagnosis", name)
    return row


def cancel_job(db: Session, name: str) -> JobRow:
    """End a job that is not done; who works at it finds out.

    Raises:
        NotThereError: there is none of this id.
        StateError: it has ended already.
    """
    row = db.get(JobRow, name, with_for_update=True)
    if row is None:
        raise NotThereError("diagnosis", name)
    if row.state in ENDED:
        raise StateError(f"diagnosis {name} is {row.state} already")
    row.state, row.doing, row.changed = "cancelled", "", time.time()
    return row


def job_view(row: JobRow) -> Job:
    """Return a job as clients see it."""
    return Job.model_validate(
        {
            "id": row.id, "recordings": json.loads(row.recordings), "state": row.state,
            "progress": row.progress, "doing": row.doing, "verdict": row.verdict, "says": row.says,
            "error": row.error, "attempts": row.attempts, "created": row.created, "changed": row.changed,
        }
    )  # fmt: skip


def house_keeping(now: float) -> tuple[Update | Delete, ...]:
    """Return what ends sessions that nobody went on with, and forgets answers that nobody asks for again."""
    idle = SessionRow.state.in_(OPEN) & (SessionRow.state != "driving") & (SessionRow.expires < now)
    return (
        update(SessionRow).where(idle).values(state="expired"),
        delete(AnswerRow).where(AnswerRow.created < now - REMEMBERED),
    )


class Worker:
    """A thread that looks for work; any number of services may share a database."""

    def __init__(self, database: Database, hub: Hub, desk: Desk, instance: str, unpacked: int) -> None:
        self._database, self._hub, self._desk = database, hub, desk
        self._instance, self._unpacked = instance, unpacked
        self._ending, self._wake = threading.Event(), threading.Event()
        self._thread = threading.Thread(target=self._run, name="jobs", daemon=True)

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def close(self) -> None:
        """End; a job that is going on is given back."""
        self._ending.set()
        self._wake.set()
        if self._thread.is_alive():
            self._thread.join(5.0)

    def wake(self) -> None:
        """Look at once."""
        self._wake.set()

    def _run(self) -> None:
        while not self._ending.is_set():
            try:
                self._sweep()
                found = self._claim()
                if found is not None:
                    self._work(found)
                    continue
            except SQLAlchemyError:
                _log.exception("the database did not answer; tried again")
            self._wake.wait(LOOK)
            self._wake.clear()

    def _sweep(self) -> None:
        """Give back what services that have died were working at."""
        now = time.time()
        with self._database.reading() as db:
            stale = db.scalar(select(JobRow.id).where(JobRow.state == "running", JobRow.lease < now).limit(1))
        if stale is not None:
            with self._database.writing() as db:
                lost = select(JobRow).where(JobRow.state == "running", JobRow.lease < now).with_for_update()
                for row in db.scalars(lost):
                    _give_back(row, "the service that worked at it has ended")
        with self._database.writing() as db:
            orphans = interrupt_orphans(db)
            for statement in house_keeping(now):
                db.execute(statement)
        for session in orphans:
            self._desk.tell(session)

    def _claim(self) -> str | None:
        with self._database.reading() as db:
            if db.scalar(select(JobRow.id).where(JobRow.state == "queued").limit(1)) is None:
                return None
        with self._database.writing() as db:
            row = db.scalars(
                select(JobRow)
                .where(JobRow.state == "queued")
                .order_by(JobRow.created)
                .limit(1)
                .with_for_update(skip_locked=True)
            ).first()
            if row is None:
                return None
            row.state, row.owner, row.attempts = "running", self._instance, row.attempts + 1
            row.lease = row.changed = time.time()
            row.lease += LEASE
            row.doing = "reading the recordings"
            return row.id

    def _work(self, name: str) -> None:
        """Have a child diagnose, and follow it."""
        self._tell(name)
        with tempfile.TemporaryDirectory() as place:
            named = self._unpack(name, Path(place))
            context = multiprocessing.get_context("spawn")
            mine, its = context.Pipe()
            child = context.Process(target=run, args=(its, named), daemon=True)
            child.start()
            its.close()
            try:
                self._end(name, self._follow(name, mine, child))
            finally:
                child.kill()
                child.join()
        self._tell(name)

    def _unpack(self, name: str, place: Path) -> list[tuple[str, str]]:
        """Return the recordings' names and the folders into which they are unpacked."""
        named = []
        with self._database.reading() as db:
            for one in json.loads(job(db, name).recordings):
                row = db.get(RecordingRow, one)
                if row is not None:
                    folder = place / row.id
                    folder.mkdir()
                    named.append((row.name, str(unpack(row.content, folder, self._unpacked))))
        return named

    def _follow(self, name: str, mine: Connection, child: BaseProcess) -> dict[str, Any] | None:
        """Return what the child says in the end; None where it was cancelled, or has died."""
        renewed = 0.0
        try:
            while True:
                if mine.poll(TOLD):
                    said: dict[str, Any] = mine.recv()
                    if "progress" not in said:
                        return said
                elif not child.is_alive():
                    return {"died": f"its process ended with code {child.exitcode}"}
                else:
                    said = {}
                now = time.monotonic()
                if now - renewed >= TOLD:
                    renewed = now
                    if self._ending.is_set() or not self._renew(name, said):
                        return None
        except EOFError:
            child.join(1.0)
            return {"died": f"its process ended with code {child.exitcode}"}

    def _renew(self, name: str, said: dict[str, Any]) -> bool:
        """Note how far the child is; return whether anybody still wants the answer."""
        with self._database.writing() as db:
            row = db.get(JobRow, name, with_for_update=True)
            if row is None or row.state != "running" or row.owner != self._instance:
                return False
            row.lease = time.time() + LEASE
            if said:
                row.progress, row.doing = said["progress"], said["doing"][:200]
        if said:
            self._tell(name)
        return True

    def _end(self, name: str, said: dict[str, Any] | None) -> None:
        with self._database.writing() as db:
            row = db.get(JobRow, name, with_for_update=True)
            if row is None or row.state != "running" or row.owner != self._instance:
                return
            if said is None:
                _give_back(row, "the service was stopped")
            elif "died" in said:
                _give_back(row, said["died"])
            elif "error" in said:
                row.state, row.error, row.doing = "failed", said["error"], ""
            else:
                row.state, row.progress, row.doing = "done", 1.0, ""
                row.verdict, row.says = said["verdict"], said["says"]
                row.result, row.report = said["result"], said["report"]
            row.changed = time.time()

    def _tell(self, name: str) -> None:
        with self._database.reading() as db:
            self._hub.publish("job", job_view(job(db, name)).model_dump())


def _give_back(row: JobRow, reason: str) -> None:
    """Queue a job again, or give it up after several attempts."""
    row.owner = row.lease = None
    row.changed = time.time()
    if row.attempts >= ATTEMPTS:
        row.state, row.error, row.doing = "failed", f"given up after {row.attempts} attempts: {reason}", ""
    else:
        row.state, row.doing = "queued", f"waiting again: {reason}"
