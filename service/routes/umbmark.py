"""UMBmark over REST: start, sample, solve, accept, abort."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

from fastapi import APIRouter, Query
from fastapi import Path as PathParameter
from fastapi.responses import Response
from sqlalchemy.orm import Session as Db

from service.errors import NotThereError, ValueProblem
from service.once import Answer, Call, Operating, Reading
from service.problems import documented
from service.recordings import loaded
from service.robot.desk import lease
from service.robot.live import Work
from service.routes.common import ALWAYS, After, Done, IfMatch, Limit, Page, condition, etag
from service.store import vehicles
from service.store.lists import page
from service.store.tables import RecordingRow, SampleRow, SessionRow
from service.umbmark import sessions
from service.umbmark.models import (
    Accept,
    Id,
    Result,
    Sample,
    SampleGiven,
    SampleOfFixes,
    Session,
    SessionStart,
    Solve,
    State,
    Turn,
)
from vehicle.parameters import TruckName
from vehicle.se2 import Array

router = APIRouter(prefix="/v1/umbmark/sessions", tags=["umbmark"], responses=ALWAYS)
Name = Annotated[Id, PathParameter(description="of the session")]


@router.post(
    "", operation_id="startSession", status_code=201, response_model=Session, responses=documented(404)
)
def start(body: SessionStart, call: Operating) -> Response:
    """Start a session; with `how: drive` the robot begins to drive."""
    parts = call.parts
    begun: list[Work] = []

    def act(db: Db) -> Answer:
        row = sessions.start(db, body, body.vehicle or parts.vehicle, parts.settings.lifetime)
        if body.how == "drive":
            begun.append(_drive(call, row))
        return Answer(sessions.full_view(db, row), 201, {"Location": f"{router.prefix}/{row.id}"})

    return _driven(call, begun, lambda: call.once(body, act))


def _drive(call: Call, row: SessionRow) -> Work:
    """Reserve the robot on the bus for a session; return what it is going to do.

    Raises:
        ValueProblem: the session is of another vehicle.
        AbsentError: the robot is not there.
        StateError: it drives for another session.
    """
    if row.vehicle != call.parts.vehicle:
        raise ValueProblem(
            "vehicle",
            f"{row.vehicle!r} is not on the bus; only {call.parts.vehicle!r} can drive",
        )
    call.parts.live.reserve(row.id)
    row.state, row.detail = "driving", ""
    row.owner, row.lease = call.parts.settings.instance, lease()
    return Work(row.id, row.side, row.speed, row.lifeline)


def _driven(call: Call, begun: list[Work], made: Callable[[], Response]) -> Response:
    """Let the robot go once the session is written down, and not at all if it could not be."""
    live = call.parts.live
    try:
        response = made()
    except BaseException:
        for work in begun:
            live.release(work.session)
        raise
    for work in begun:
        live.begin(work)
        call.parts.desk.tell(work.session)
    return response


@router.get("", operation_id="listSessions", response_model=Page[Session], responses=documented(404))
def every(
    call: Reading, limit: Limit = 50, after: After = None, state: Annotated[State | None, Query()] = None
) -> Page[Session]:
    """Return sessions, newest first, without their runs."""
    with call.parts.database.reading() as db:
        where = () if state is None else (SessionRow.state == state,)
        rows, following = page(db, SessionRow, limit, after, *where)
        counts = sessions.counts(db, [row.id for row in rows])
        return Page(items=[sessions.view(row, counts[row.id]) for row in rows], next=following)


@router.get("/{session_id}", operation_id="getSession", response_model=Session, responses=documented(404))
def one(session_id: Name, call: Reading) -> Session:
    """Return a session with its runs."""
    call.parts.live.seen(session_id)
    with call.parts.database.reading() as db:
        return sessions.full_view(db, sessions.session(db, session_id))


@router.post(
    "/{session_id}/samples",
    operation_id="addSample",
    status_code=201,
    response_model=Sample,
    responses=documented(404, 410),
)
def sample(session_id: Name, body: SampleGiven, call: Operating) -> Response:
    """Add a run by its fixes, or the runs of a recording; what is answered 201 stays."""
    begun: list[Work] = []

    def act(db: Db) -> Answer:
        row = sessions.opened(db, session_id, "sample")
        waited = row.state == "measuring"
        if isinstance(body, SampleOfFixes):
            added = sessions.add_given(db, row, body)
        else:
            added = _of_recording(call, db, row, body.recording)
        sessions.touched(row, call.parts.settings.lifetime)
        db.flush()
        if waited:
            _go_on(call, db, row, begun)
        last = sessions.sample_view(added[-1])
        return Answer(last, 201, {"Location": f"{router.prefix}/{session_id}/samples/{last.number}"})

    response = _driven(call, begun, lambda: call.once(body, act))
    call.parts.desk.tell(session_id)
    return response


def _go_on(call: Call, db: Db, row: SessionRow, begun: list[Work]) -> None:
    """Drive the next square after one was measured, or end."""
    count = sessions.counts(db, [row.id])[row.id]
    if min(count.cw, count.ccw) >= row.runs:
        row.state, row.detail = "collecting", "all squares are driven: solve"
    else:
        begun.append(_drive(call, row))


def _of_recording(call: Call, db: Db, row: SessionRow, recording: str) -> list[SampleRow]:
    """Add every square of an uploaded recording.

    Raises:
        NotThereError: there is no such recording.
        ValueProblem: it is of another robot, or holds no square.
        CalibrationError: a square lacks its fixes, or is none.
    """
    from calib.recordings import has_fixes, square_runs

    kept = db.get(RecordingRow, recording)
    if kept is None:
        raise NotThereError("recording", recording)
    if kept.vehicle != row.vehicle:
        raise ValueProblem(
            "recording",
            f"it is of the robot {kept.vehicle!r}; this session is of {row.vehicle!r}",
        )
    vehicle = vehicles.parameters(vehicles.version(db, row.vehicle, row.vehicle_version))
    with tempfile.TemporaryDirectory() as place:
        (drive,) = loaded([kept], Path(place), call.parts.settings.unpacked)
    found: list[tuple[Turn, dict[TruckName, Array]]] = []
    for truck, size in vehicle.trucks.items():
        for number, run in enumerate(square_runs(drive, truck) if has_fixes(drive, truck) else ()):
            run.check(size, row.side)
            if number == len(found):
                found.append((run.direction, {}))
            found[number][1][truck] = run.return_error(size)
    if not found:
        raise ValueProblem("recording", "no square with fixes before and after it (run.toml, poses.csv)")
    return [sessions.add(db, row, turn, errors, kept.name, kept.id) for turn, errors in found]


@router.delete(
    "/{session_id}/samples/{number}",
    operation_id="removeSample",
    response_model=Done,
    responses=documented(404, 410),
)
def remove(
    session_id: Name, number: Annotated[int, PathParameter(ge=1, le=1_000_000)], call: Operating
) -> Response:
    """Leave a run out."""

    def act(db: Db) -> Answer:
        row = sessions.opened(db, session_id, "remove")
        sessions.remove(db, row, number)
        sessions.touched(row, call.parts.settings.lifetime)
        return Answer(Done(done=f"run {number} is left out"))

    response = call.once(None, act)
    call.parts.desk.tell(session_id)
    return response


@router.post(
    "/{session_id}/solve",
    operation_id="solveSession",
    response_model=Result,
    responses=documented(404, 410),
)
def solve(session_id: Name, call: Operating, body: Solve | None = None) -> Response:
    """Solve with the runs that there are; more may be added and solved again."""

    def act(db: Db) -> Answer:
        row = sessions.opened(db, session_id, "solve")
        result = sessions.solve(db, row, (body or Solve()).method)
        sessions.touched(row, call.parts.settings.lifetime)
        return Answer(result, 200, {"ETag": etag(result.revision)})

    response = call.once(body, act)
    call.parts.desk.tell(session_id)
    return response


@router.get(
    "/{session_id}/result", operation_id="getResult", response_model=Result, responses=documented(404)
)
def result(session_id: Name, call: Reading, response: Response) -> Result:
    """Return the result of the last solve."""
    with call.parts.database.reading() as db:
        found = sessions.result(sessions.session(db, session_id))
    response.headers["ETag"] = etag(found.revision)
    return found


@router.get(
    "/{session_id}/plot.{kind}",
    operation_id="getPlot",
    response_class=Response,
    responses={
        **documented(404),
        200: {"content": {"image/svg+xml": {"schema": {"type": "string"}}, "image/png": {}}},
    },
)
def plot(
    session_id: Name, kind: Annotated[str, PathParameter(pattern="^(svg|png)$")], call: Reading
) -> Response:
    """Return the clusters before and after, as U Fig. 11."""
    from figures.plots import cluster_figure, rendered
    from service.umbmark.result import experiments_of, panels

    with call.parts.database.reading() as db:
        row = sessions.session(db, session_id)
        found = sessions.result(row)
        vehicle = vehicles.parameters(vehicles.version(db, row.vehicle, row.vehicle_version))
        experiments = experiments_of(row, sessions.samples(db, row), vehicle)
    picture = rendered(cluster_figure(panels(experiments, found)), kind)
    return Response(picture, media_type="image/svg+xml" if kind == "svg" else "image/png")


@router.post(
    "/{session_id}/accept",
    operation_id="acceptResult",
    response_model=Session,
    responses=documented(404, 410, 412, 428),
)
def accept(session_id: Name, call: Operating, if_match: IfMatch, body: Accept | None = None) -> Response:
    """Make the result the newest version of the vehicle; the former ones stay."""
    wanted = condition(if_match)
    force = (body or Accept()).force

    def act(db: Db) -> Answer:
        row = sessions.opened(db, session_id, "accept")
        version = sessions.accept(db, row, wanted, force=force)
        sessions.touched(row, call.parts.settings.lifetime)
        return Answer(
            sessions.full_view(db, row),
            200,
            {"Location": f"/v1/vehicles/{row.vehicle}", "ETag": etag(version.version)},
        )

    response = call.once(body, act)
    call.parts.live.reload()
    call.parts.desk.tell(session_id)
    return response


@router.post(
    "/{session_id}/resume",
    operation_id="resumeSession",
    response_model=Session,
    responses=documented(404, 410),
)
def resume(session_id: Name, call: Operating) -> Response:
    """Drive the squares that are left, after an interruption."""
    begun: list[Work] = []

    def act(db: Db) -> Answer:
        row = sessions.opened(db, session_id, "resume")
        sessions.touched(row, call.parts.settings.lifetime)
        begun.append(_drive(call, row))
        return Answer(sessions.full_view(db, row))

    return _driven(call, begun, lambda: call.once(None, act))


@router.post(
    "/{session_id}/abort",
    operation_id="abortSession",
    response_model=Session,
    responses=documented(404, 410),
)
def abort(session_id: Name, call: Operating) -> Response:
    """End a session; a robot that drives for it stops."""
    if call.parts.live.driving == session_id:
        call.parts.live.halt("the session was aborted")

    def act(db: Db) -> Answer:
        row = sessions.opened(db, session_id, "abort")
        row.state, row.detail, row.owner, row.lease = "aborted", "aborted", None, None
        sessions.touched(row, call.parts.settings.lifetime)
        return Answer(sessions.full_view(db, row))

    response = call.once(None, act)
    call.parts.desk.tell(session_id)
    return response
