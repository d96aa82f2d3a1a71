"""The reports of the robot's thread about a session, written to the database."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from omnimate.files.recordings.folder import load_recording
from omnimate.files.recordings.zipped import pack
from omnimate.service.store import vehicles
from omnimate.service.store.recordings import summarize
from omnimate.service.store.tables import SessionRow, find_row
from omnimate.service.umbmark.samples import add_sample, squares_of
from omnimate.service.umbmark.sessions import (
    count_samples,
    drives_for,
    end_lease,
    next_direction,
    renew_lease,
    session_view,
    vehicle_of,
)
from omnimate.vehicle.errors import OmnimateError
from omnimate.vehicle.odometry import dead_reckon
from omnimate.vehicle.se2 import between

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from omnimate.service.store.database import Database
    from omnimate.service.store.recordings import RecordingStore
    from omnimate.service.umbmark.models import Direction
    from omnimate.vehicle.parameters import TruckName, VehicleParameters
    from omnimate.vehicle.recording import Recording

    Announce = Callable[[str, str, Callable[[str], dict[str, Any]]], None]  # as `EventStream.announce`

MEASURE = "one {} square is driven: measure where the robot stands, and post it as a sample"


class LapError(OmnimateError):
    """A lap from which no return error can be calculated, or that its session does not want."""


class SessionReporter:
    """Reports on the sessions that this service's robot drives for; each call is one transaction."""

    def __init__(
        self, database: Database, announce: Announce, vehicle: str, instance: str, recordings: RecordingStore
    ) -> None:
        self._database, self._announce, self._recordings = database, announce, recordings
        self._vehicle, self._instance = vehicle, instance

    def vehicle(self) -> VehicleParameters:
        """Return the robot's newest parameters."""
        with self._database.reading() as db:
            return vehicles.parameters_of(vehicles.newest(db, self._vehicle))

    def next_direction(self, session: str) -> Direction | None:
        """Return the direction of the next lap, None when all are driven; LapError if none is wanted."""
        with self._database.reading() as db:
            row = find_row(db, SessionRow, session)
            self._require_driving(row)
            return next_direction(db, row)

    def lap_done(self, session: str, direction: Direction, folder: Path) -> None:
        """Store a lap's recording, and its return errors where fixes were measured.

        Without fixes the session waits for a person to measure where the robot stands.

        Raises:
            LapError: the lap gives no return error, or the session does not want it any more.
            CalibrationError: the lap is not a square with a fix before and after it.
        """
        recording = replace(load_recording(folder), source=f"the {direction} square")
        with self._database.reading() as db:
            row = find_row(db, SessionRow, session)
            self._require_driving(row)
            vehicle = vehicle_of(db, row)
        measured = recording.poses is not None
        squares = squares_of(recording, vehicle, row.side) if measured else []
        if measured and not squares:
            raise LapError("the lap has no fixes before and after it")
        ends = {} if measured else _ends(recording)
        stored = self._recordings.add(f"session {session}, {direction}", pack(folder), summarize(recording))
        with self._database.writing() as db:
            row = find_row(db, SessionRow, session, for_change=True)
            self._require_driving(row)
            db.add(stored)
            if measured:
                add_sample(db, row, squares[-1], "driven", stored.id)
            else:
                row.pending = {"direction": direction, "calculated": ends}
                end_lease(row, "measuring", MEASURE.format(direction))
            row.changed = time.time()
        self.announce(session)

    def finished(self, session: str) -> None:
        """Note that all runs are driven."""
        self._end(session, "collecting", "all squares are driven: solve")

    def interrupted(self, session: str, reason: str) -> None:
        """Note that driving has ended before all runs were driven."""
        self._end(session, "interrupted", f"interrupted: {reason}"[:1000])

    def renew(self, session: str) -> bool:
        """Note that this service still drives for the session; return whether it does."""
        with self._database.writing() as db:
            row = find_row(db, SessionRow, session, for_change=True)
            is_ours = drives_for(row, self._instance)
            if is_ours:
                renew_lease(row)
        return is_ours

    def announce(self, session: str) -> None:
        """Publish that a session has changed."""
        self._announce("session", session, self._view)

    def _end(self, session: str, state: str, detail: str) -> None:
        with self._database.writing() as db:
            row = find_row(db, SessionRow, session, for_change=True)
            if drives_for(row, self._instance):
                end_lease(row, state, detail)
        self.announce(session)

    def _require_driving(self, row: SessionRow) -> None:
        if not drives_for(row, self._instance):
            raise LapError(f"session {row.id} is {row.state}")

    def _view(self, session: str) -> dict[str, Any]:
        with self._database.reading() as db:
            row = find_row(db, SessionRow, session)
            view = session_view(row, count_samples(db, [session])[session])
        return view.model_dump(exclude={"samples"})


def _ends(recording: Recording) -> dict[TruckName, list[float]]:
    """Return the pose of each truck at the end of the lap by odometry, seen from its start."""
    assert recording.run is not None  # it was driven by a program
    lap = recording.run.laps[-1]
    inside = recording.between(lap.start, lap.end)
    ends = {}
    for truck in recording.vehicle.trucks:
        path = dead_reckon(recording, truck)[inside]
        ends[truck] = between(path[0], path[-1]).tolist()
    return ends
