"""The runs of a UMBmark session over REST: added from fixes or from a recording, and removed."""

from __future__ import annotations

import time
from typing import Annotated

from fastapi import APIRouter
from fastapi import Path as PathParameter
from fastapi.responses import Response
from sqlalchemy.orm import Session as Db

from omnimate.service.calls import Answer, Call, Operating
from omnimate.service.errors import InvalidValueError
from omnimate.service.problems import documented
from omnimate.service.routes.common import ALWAYS, Done
from omnimate.service.routes.umbmark_sessions import PREFIX, SessionDrives, SessionId
from omnimate.service.store.rows import find_row
from omnimate.service.store.tables import RecordingRow, SampleRow, SessionRow
from omnimate.service.umbmark.models import Sample, SampleGiven, SampleOfFixes
from omnimate.service.umbmark.samples import add_measured_sample, add_sample, remove_sample, squares_of
from omnimate.service.umbmark.sessions import (
    count_samples,
    extend_lifetime,
    require_call,
    session_for,
    vehicle_of,
)

router = APIRouter(prefix=PREFIX, tags=["umbmark"], responses=ALWAYS)


@router.post(
    "/{session_id}/samples",
    operation_id="addSample",
    status_code=201,
    response_model=Sample,
    responses=documented(410),
)
def add(session_id: SessionId, body: SampleGiven, call: Operating) -> Response:
    """Add a run by its fixes, or all runs of a recording. A run that was answered with 201 is not lost."""
    drives = SessionDrives(call.components)

    def compute() -> list[SampleRow]:
        return [] if isinstance(body, SampleOfFixes) else _squares(call, session_id, body.recording)

    def act(db: Db, squares: list[SampleRow]) -> Answer:
        row = session_for(db, session_id, "sample")
        was_measuring = row.state == "measuring"
        if isinstance(body, SampleOfFixes):
            sample = add_measured_sample(db, row, body)
        else:
            recording = find_row(db, RecordingRow, body.recording)  # it may have been deleted meanwhile
            for square in squares:
                sample = add_sample(db, row, square, recording.name, recording.id)
        extend_lifetime(row, call.components.settings.lifetime)
        db.flush()
        if was_measuring:
            _continue_driving(db, row, drives)
        location = f"{PREFIX}/{session_id}/samples/{sample.number}"
        return Answer(Sample.of(sample), 201, {"Location": location})

    response = drives.begin_after(lambda: call.compute_and_change(body, compute, act))
    call.components.reporter.announce(session_id)
    return response


def _continue_driving(db: Db, row: SessionRow, drives: SessionDrives) -> None:
    """Drive the next square after a person has measured the last one, unless all are driven."""
    counts = count_samples(db, [row.id])[row.id]
    if min(counts.cw, counts.ccw) >= row.runs:
        row.state, row.detail = "collecting", "all squares are driven: solve"
    else:
        drives.prepare(row)


def _squares(call: Call, session_id: str, recording_id: str) -> list[SampleRow]:
    """Return the squares of an uploaded recording, of which there is one at least.

    Raises:
        NotFoundError: there is no such recording.
        InvalidValueError: the recording is of another robot, or holds no square.
        CalibrationError: a lap of the recording is no square, or has no fix before or after it.
    """
    with call.components.database.reading() as db:
        row = find_row(db, SessionRow, session_id)
        require_call(row, "sample", time.time())
        stored = find_row(db, RecordingRow, recording_id)
        vehicle = vehicle_of(db, row)
    if stored.vehicle != row.vehicle:
        raise InvalidValueError(
            "recording", f"it is of the robot {stored.vehicle!r}; this session is of {row.vehicle!r}"
        )
    recording = call.components.recordings.load(stored)
    squares = squares_of(recording, vehicle, row.side)
    if not squares:
        raise InvalidValueError("recording", "no square with fixes before and after it (run.toml, poses.csv)")
    return squares


@router.delete(
    "/{session_id}/samples/{number}",
    operation_id="removeSample",
    response_model=Done,
    responses=documented(410),
)
def remove(
    session_id: SessionId, number: Annotated[int, PathParameter(ge=1, le=1_000_000)], call: Operating
) -> Response:
    """Remove a run from the session."""

    def act(db: Db) -> Answer:
        row = session_for(db, session_id, "remove")
        remove_sample(db, row, number)
        extend_lifetime(row, call.components.settings.lifetime)
        return Answer(Done(done=f"run {number} is removed"))

    response = call.change(None, act)
    call.components.reporter.announce(session_id)
    return response
