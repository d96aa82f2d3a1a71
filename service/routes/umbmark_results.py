"""The result of a UMBmark session over REST: solved, read, drawn, accepted."""

from __future__ import annotations

import time
from typing import Annotated

from fastapi import APIRouter
from fastapi import Path as PathParameter
from fastapi.responses import Response
from sqlalchemy.orm import Session as Db

from omnimate.service.calls import Answer, Operating, Reading
from omnimate.service.problems import documented
from omnimate.service.routes.common import ALWAYS, IfMatch, etag, expected_version
from omnimate.service.routes.umbmark_sessions import PREFIX, SessionId
from omnimate.service.store.tables import SampleRow, SessionRow, find_row
from omnimate.service.umbmark import sessions
from omnimate.service.umbmark.models import Accept, Result, Session, Solve

router = APIRouter(prefix=PREFIX, tags=["umbmark"], responses=ALWAYS)


@router.post("/{session_id}/solve", response_model=Result, responses=documented(410))
def solve_session(session_id: SessionId, call: Operating, body: Solve | None = None) -> Response:
    """Solve the session with the runs that it has. More runs may be added, and the session solved again."""

    def compute() -> tuple[list[SampleRow], Result]:
        from omnimate.service.umbmark.result import make_result  # imports scipy.stats, which takes a second

        with call.components.database.reading() as db:
            row = find_row(db, SessionRow, session_id)
            sessions.require_call(row, "solve", time.time())
            samples, vehicle = sessions.samples_of(db, row), sessions.vehicle_of(db, row)
        return samples, make_result(row, samples, vehicle, (body or Solve()).method)

    def act(db: Db, computed: tuple[list[SampleRow], Result]) -> Answer:
        row = sessions.session_for(db, session_id, "solve", call.components.settings.lifetime)
        samples, result = computed
        sessions.store_result(db, row, samples, result)
        return Answer(result, 200, {"ETag": etag(result.revision)})

    response = call.compute_and_change(body, compute, act)
    call.components.reporter.announce(session_id)
    return response


@router.get("/{session_id}/result")
def get_result(session_id: SessionId, call: Reading, response: Response) -> Result:
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
    from omnimate.service.umbmark.result import cluster_panels, experiments_of

    with call.components.database.reading() as db:
        row = find_row(db, SessionRow, session_id)
        result = sessions.last_result(row)
        experiments = experiments_of(row, sessions.samples_of(db, row), sessions.vehicle_of(db, row))
    picture = rendered(cluster_figure(cluster_panels(experiments, result.method)), kind)
    return Response(picture, media_type="image/svg+xml" if kind == "svg" else "image/png")


@router.post("/{session_id}/accept", response_model=Session, responses=documented(410, 412, 428))
def accept_result(
    session_id: SessionId, call: Operating, if_match: IfMatch, body: Accept | None = None
) -> Response:
    """Make the result the newest version of the vehicle. The former versions stay."""
    revision = expected_version(if_match)
    force = (body or Accept()).force

    def act(db: Db) -> Answer:
        row = sessions.session_for(db, session_id, "accept", call.components.settings.lifetime)
        version = sessions.accept_result(db, row, revision, call.caller.key_name, force=force)
        headers = {"Location": f"/v1/vehicles/{row.vehicle}", "ETag": etag(version.version)}
        return Answer(sessions.session_with_samples(db, row), 200, headers)

    response = call.change(body, act)
    call.components.robot.reload()
    call.components.reporter.announce(session_id)
    return response
