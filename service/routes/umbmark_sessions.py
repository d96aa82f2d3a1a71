"""UMBmark sessions over REST: started, resumed, aborted; their runs; their result, solved and accepted."""

from __future__ import annotations

import time
from functools import partial
from typing import TYPE_CHECKING, Annotated

from fastapi import APIRouter, Query
from fastapi import Path as PathParameter
from fastapi.responses import Response
from sqlalchemy.orm import Session as Db

from omnimate.service.calls import Answer, Call, Operating, Reading
from omnimate.service.errors import InvalidValueError
from omnimate.service.problems import documented
from omnimate.service.robot.reservation import DriveOrder
from omnimate.service.routes.common import ALWAYS, After, Done, IfMatch, Limit, Page, etag, expected_version
from omnimate.service.routes.vehicles import headers_of
from omnimate.service.store.tables import RecordingRow, SampleRow, SessionRow, find_row, read_page
from omnimate.service.umbmark import models, samples, sessions
from omnimate.service.umbmark.result import cluster_panels, experiments_of, make_result

if TYPE_CHECKING:
    from collections.abc import Callable

    from omnimate.service.components import Components


class SessionDrives:
    """The drives that a call prepares."""

    def __init__(self, components: Components) -> None:
        self._components = components
        self._orders: list[DriveOrder] = []

    def prepare(self, row: SessionRow) -> None:
        """Reserve the robot on the bus, which must be that of the session, as `Reservation.reserve`."""
        components = self._components
        if row.vehicle != components.vehicle:
            raise InvalidValueError(
                "vehicle", f"{row.vehicle!r} is not on the bus; only {components.vehicle!r} can drive"
            )
        components.robot.reservation.reserve(row.id)
        sessions.take_lease(row, components.settings.instance)
        self._orders.append(DriveOrder(row.id, row.side, row.speed, row.lifeline))

    def begin_after(self, commit: Callable[[], Response]) -> Response:
        """Commit the session, then let the robot drive; it does not drive where the commit fails."""
        reservation = self._components.robot.reservation
        try:
            response = commit()
        except BaseException:
            for order in self._orders:
                reservation.release(order.session)
            raise
        for order in self._orders:
            if reservation.begin(order):
                self._components.reporter.announce(order.session)
            else:
                self._components.reporter.interrupted(
                    order.session, "the robot was lost before it began to drive"
                )
        return response


PREFIX = "/v1/umbmark/sessions"
SessionId = Annotated[models.Id, PathParameter(description="The id of the session.")]
router = APIRouter(prefix=PREFIX, tags=["umbmark"], responses=ALWAYS)


@router.post("", status_code=201, response_model=models.Session)
def start_session(body: models.SessionStart, call: Operating) -> Response:
    """Start a session. With `how: drive` the robot begins to drive."""
    components, drives = call.components, SessionDrives(call.components)

    def act(db: Db) -> Answer:
        vehicle = body.vehicle or components.vehicle
        row = sessions.start_session(db, body, vehicle, components.settings.lifetime)
        if body.how == "drive":
            drives.prepare(row)
        return Answer(sessions.session_with_samples(db, row), 201, {"Location": f"{PREFIX}/{row.id}"})

    return drives.begin_after(lambda: call.change(body, act))


@router.get("")
def list_sessions(
    call: Reading,
    limit: Limit = 50,
    after: After = None,
    state: Annotated[models.State | None, Query()] = None,
) -> Page[models.Session]:
    """Return the sessions, newest first, without their samples."""
    with call.components.database.reading() as db:
        where = () if state is None else (SessionRow.state == state,)
        rows, next_page = read_page(db, SessionRow, limit, after, *where)
        counts = sessions.count_samples(db, [row.id for row in rows])
        return Page(items=[sessions.session_view(row, counts[row.id]) for row in rows], next=next_page)


@router.get("/{session_id}")
def get_session(session_id: SessionId, call: Reading) -> models.Session:
    """Return a session with its samples."""
    call.components.robot.reservation.note_client(session_id)
    with call.components.database.reading() as db:
        return sessions.session_with_samples(db, find_row(db, SessionRow, session_id))


@router.post("/{session_id}/resume", response_model=models.Session, responses=documented(410))
def resume_session(session_id: SessionId, call: Operating) -> Response:
    """Drive the runs that are still missing, after an interruption."""
    drives = SessionDrives(call.components)

    def act(db: Db) -> Answer:
        row = sessions.session_for(db, session_id, "resume", call.components.settings.lifetime)
        drives.prepare(row)
        return Answer(sessions.session_with_samples(db, row))

    return drives.begin_after(lambda: call.change(None, act))


@router.post("/{session_id}/abort", response_model=models.Session, responses=documented(410))
def abort_session(session_id: SessionId, call: Operating) -> Response:
    """End a session. A robot that drives for this session stops."""
    call.components.robot.reservation.stop("the session was aborted", session_id)

    def act(db: Db) -> Answer:
        row = sessions.session_for(db, session_id, "abort", call.components.settings.lifetime)
        sessions.end_lease(row, "aborted", "aborted")
        return Answer(sessions.session_with_samples(db, row))

    response = call.change(None, act)
    call.components.reporter.announce(session_id)
    return response


@router.post(
    "/{session_id}/samples", status_code=201, response_model=models.Sample, responses=documented(410)
)
def add_sample(session_id: SessionId, body: models.SampleGiven, call: Operating) -> Response:
    """Add a run by its fixes, or all runs of a recording. A run that was answered with 201 is not lost."""
    drives = SessionDrives(call.components)

    def compute() -> list[SampleRow]:
        return [] if isinstance(body, models.SampleOfFixes) else _squares(call, session_id, body.recording)

    def act(db: Db, squares: list[SampleRow]) -> Answer:
        row = sessions.session_for(db, session_id, "sample", call.components.settings.lifetime)
        was_measuring = row.state == "measuring"
        if isinstance(body, models.SampleOfFixes):
            sample = samples.add_measured_sample(db, row, body)
        else:
            recording = find_row(db, RecordingRow, body.recording)  # it may have been deleted meanwhile
            samples.require_new(db, row, recording.id)
            for square in squares:
                sample = samples.add_sample(db, row, square, recording.name, recording.id)
        db.flush()
        if was_measuring:
            _continue_driving(db, row, drives)
        location = f"{PREFIX}/{session_id}/samples/{sample.number}"
        return Answer(models.Sample.of(sample), 201, {"Location": location})

    response = drives.begin_after(lambda: call.compute_and_change(body, compute, act))
    call.components.reporter.announce(session_id)
    return response


def _continue_driving(db: Db, row: SessionRow, drives: SessionDrives) -> None:
    """Drive the next square after a person has measured the last one, unless all are driven."""
    if sessions.next_direction(db, row) is None:
        row.state, row.detail = "collecting", "all squares are driven: solve"
    else:
        drives.prepare(row)


def _squares(call: Call, session_id: str, recording_id: str) -> list[SampleRow]:
    """Return the squares of an uploaded recording of the session's robot, of which there is one at least."""
    with call.components.database.reading() as db:
        row = find_row(db, SessionRow, session_id)
        sessions.require_call(row, "sample", time.time())
        stored = find_row(db, RecordingRow, recording_id)
        vehicle = sessions.vehicle_of(db, row)
    if stored.vehicle != row.vehicle:
        raise InvalidValueError(
            "recording", f"it is of the robot {stored.vehicle!r}; this session is of {row.vehicle!r}"
        )
    extract = partial(samples.squares_of, vehicle=vehicle, side=row.side)
    squares = call.components.recordings.read(stored, extract)
    if not squares:
        raise InvalidValueError("recording", "no square with fixes before and after it (run.toml, poses.csv)")
    return squares


@router.delete("/{session_id}/samples/{number}", response_model=Done, responses=documented(410))
def remove_sample(
    session_id: SessionId, number: Annotated[int, PathParameter(ge=1, le=1_000_000)], call: Operating
) -> Response:
    """Remove a run from the session."""

    def act(db: Db) -> Answer:
        row = sessions.session_for(db, session_id, "remove", call.components.settings.lifetime)
        samples.remove_sample(db, row, number)
        return Answer(Done(done=f"run {number} is removed"))

    response = call.change(None, act)
    call.components.reporter.announce(session_id)
    return response


@router.post("/{session_id}/solve", response_model=models.Result, responses=documented(410))
def solve_session(session_id: SessionId, call: Operating, body: models.Solve | None = None) -> Response:
    """Solve the session with the runs that it has. More runs may be added, and the session solved again."""

    def compute() -> tuple[list[SampleRow], models.Result]:
        with call.components.database.reading() as db:
            row = find_row(db, SessionRow, session_id)
            sessions.require_call(row, "solve", time.time())
            samples, vehicle = sessions.samples_of(db, row), sessions.vehicle_of(db, row)
        return samples, make_result(row, samples, vehicle, (body or models.Solve()).method)

    def act(db: Db, computed: tuple[list[SampleRow], models.Result]) -> Answer:
        row = sessions.session_for(db, session_id, "solve", call.components.settings.lifetime)
        samples, result = computed
        sessions.store_result(db, row, samples, result)
        return Answer(result, 200, {"ETag": etag(result.revision)})

    response = call.compute_and_change(body, compute, act)
    call.components.reporter.announce(session_id)
    return response


@router.get("/{session_id}/result")
def get_result(session_id: SessionId, call: Reading, response: Response) -> models.Result:
    """Return the result of the last solve."""
    with call.components.database.reading() as db:
        result = sessions.last_result(find_row(db, SessionRow, session_id))
    response.headers["ETag"] = etag(result.revision)
    return result


@router.get(
    "/{session_id}/plot.{kind}",
    response_class=Response,
    responses={
        200: {"content": {"image/svg+xml": {"schema": {"type": "string"}}, "image/png": {}}},
    },
)
def get_plot(
    session_id: SessionId, kind: Annotated[str, PathParameter(pattern="^(svg|png)$")], call: Reading
) -> Response:
    """Return a figure of the return errors before and after calibration, like U Fig. 11."""
    from omnimate.figures.clusters import cluster_figure
    from omnimate.figures.files import rendered

    with call.components.database.reading() as db:
        row = find_row(db, SessionRow, session_id)
        result = sessions.last_result(row)
        experiments = experiments_of(row, sessions.samples_of(db, row), sessions.vehicle_of(db, row))
    picture = rendered(cluster_figure(cluster_panels(experiments, result.method)), kind)
    return Response(picture, media_type="image/svg+xml" if kind == "svg" else "image/png")


@router.post("/{session_id}/accept", response_model=models.Session, responses=documented(410, 412, 428))
def accept_result(
    session_id: SessionId, call: Operating, if_match: IfMatch, body: models.Accept | None = None
) -> Response:
    """Make the result the newest version of the vehicle. The former versions stay."""
    revision = expected_version(if_match)
    force = (body or models.Accept()).force

    def act(db: Db) -> Answer:
        row = sessions.session_for(db, session_id, "accept", call.components.settings.lifetime)
        version = sessions.accept_result(db, row, revision, call.caller.key_name, force=force)
        return Answer(sessions.session_with_samples(db, row), 200, headers_of(version))

    response = call.change(body, act)
    call.components.robot.reload()
    call.components.reporter.announce(session_id)
    return response
