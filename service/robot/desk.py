"""What the robot's thread reports, written to the database."""

from __future__ import annotations

import json
import time
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from service.recordings import pack, row_of
from service.store import vehicles
from service.store.tables import SessionRow
from service.umbmark import sessions
from vehicle.errors import OmnimateError
from vehicle.folder import load_recording
from vehicle.odometry import dead_reckon
from vehicle.se2 import between

if TYPE_CHECKING:
    from pathlib import Path

    from sqlalchemy.orm import Session

    from service.hub import Hub
    from service.store.database import Database
    from service.umbmark.models import Turn
    from vehicle.parameters import TruckName, VehicleParameters
    from vehicle.recording import Recording
    from vehicle.se2 import Array

LEASE = 10.0  # [s] after which a service that says nothing is believed to be dead


class LapError(OmnimateError):
    """A lap from which no return error can be made."""


class Desk:
    """The sessions that this service's robot drives for."""

    def __init__(self, database: Database, hub: Hub, vehicle: str, instance: str) -> None:
        self._database, self._hub, self._name, self._instance = database, hub, vehicle, instance

    def vehicle(self) -> VehicleParameters:
        """Return the robot's newest parameters."""
        with self._database.reading() as db:
            return vehicles.parameters(vehicles.newest(db, self._name))

    def next_turn(self, session: str) -> Turn | None:
        """Return the direction of which fewer squares are driven, cw first; None when all are."""
        with self._database.reading() as db:
            row = sessions.session(db, session)
            if not self._mine(row):
                raise LapError(f"session {session} is {row.state}")
            count = sessions.counts(db, [session])[session]
        if min(count.cw, count.ccw) >= row.runs:
            return None
        return "cw" if count.cw <= count.ccw else "ccw"

    def lap_done(self, session: str, turn: Turn, folder: Path) -> None:
        """Keep a lap: its return errors where fixes were measured, else where odometry ended.

        Raises:
            LapError, CalibrationError: nothing can be made of it.
        """
        recording, content = replace(load_recording(folder), source=f"the {turn} square"), pack(folder)
        with self._database.writing() as db:
            row = sessions.session(db, session, change=True)
            if not self._mine(row):
                raise LapError(f"session {session} is {row.state}")
            kept = row_of(f"session {session}, {turn}", content, recording)
            db.add(kept)
            if recording.poses is None:
                self._wait_for_a_person(row, turn, recording)
            else:
                vehicle = vehicles.parameters(vehicles.version(db, row.vehicle, row.vehicle_version))
                errors = _errors(recording, vehicle, row.side)
                sessions.add(db, row, turn, errors, "driven", kept.id)
            row.changed = time.time()
        self.tell(session)

    @staticmethod
    def _wait_for_a_person(row: SessionRow, turn: Turn, recording: Recording) -> None:
        assert recording.run is not None  # it was driven by a program
        lap = recording.run.laps[-1]
        inside = recording.between(lap.start, lap.end)
        ends = {}
        for truck in recording.vehicle.trucks:
            path = dead_reckon(recording, truck)[inside]
            ends[truck] = between(path[0], path[-1]).tolist()
        row.pending = json.dumps({"direction": turn, "calculated": ends})
        row.state, row.owner, row.lease = "measuring", None, None
        row.detail = f"one {turn} square is driven: measure where the robot stands, and post it as a sample"

    def finished(self, session: str) -> None:
        """Note that all squares are driven."""
        self._end(session, "collecting", "all squares are driven: solve")

    def interrupted(self, session: str, reason: str) -> None:
        """Note that driving has ended before its time."""
        self._end(session, "interrupted", f"interrupted: {reason}"[:1000])

    def _end(self, session: str, state: str, detail: str) -> None:
        with self._database.writing() as db:
            row = sessions.session(db, session, change=True)
            if self._mine(row):
                row.state, row.detail, row.owner, row.lease = state, detail, None, None
                row.changed = time.time()
        self.tell(session)

    def renew(self, session: str) -> None:
        """Say that this service still drives for the session."""
        with self._database.writing() as db:
            row = sessions.session(db, session, change=True)
            if self._mine(row):
                row.lease = lease()

    def _mine(self, row: SessionRow) -> bool:
        return row.state == "driving" and row.owner == self._instance

    def tell(self, session: str) -> None:
        """Let everybody know that a session has changed."""
        self._hub.announce("session", session, self._look)

    def _look(self, session: str) -> dict[str, Any]:
        with self._database.reading() as db:
            row = sessions.session(db, session)
            view = sessions.view(row, sessions.counts(db, [session])[session])
        return view.model_dump(exclude={"samples"})


def lease() -> float:
    """Return until when a service that speaks now is believed to be alive [s since 1970]."""
    return time.time() + LEASE


def interrupt_orphans(db: Session) -> list[str]:
    """Interrupt sessions whose service has died; return their ids."""
    now = time.time()
    query = db.query(SessionRow).filter(SessionRow.state == "driving", SessionRow.lease < now)
    orphans = query.with_for_update().all()
    for row in orphans:
        row.state, row.owner, row.lease, row.changed = "interrupted", None, None, now
        row.detail = "interrupted: the service that drove it has ended"
    return [row.id for row in orphans]


def _errors(recording: Recording, vehicle: VehicleParameters, side: float) -> dict[TruckName, Array]:
    """Return the return errors of a lap, by truck."""
    from calib.recordings import square_runs

    errors: dict[TruckName, Array] = {}
    for name, truck in vehicle.trucks.items():
        for run in square_runs(recording, name)[-1:]:
            run.check(truck, side)
            errors[name] = run.return_error(truck)
    if not errors:
        raise LapError("the lap has no fixes before and after it")
    return errors
