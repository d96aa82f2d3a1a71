"""Whether the process lives, whether the service can do its work, and figures for Prometheus."""

from __future__ import annotations

from fastapi import APIRouter, Request
from fastapi.responses import Response
from pydantic import BaseModel
from sqlalchemy.exc import SQLAlchemyError

from service.errors import AbsentError
from service.parts import Parts
from service.problems import documented

router = APIRouter(tags=["health"])


class Health(BaseModel):
    """That all is well."""

    status: str = "ok"


@router.get("/healthz", operation_id="getHealth", response_model=Health)
async def health() -> Health:
    """Return that the process lives."""
    return Health()


@router.get("/readyz", operation_id="getReadiness", response_model=Health, responses=documented(503))
def readiness(request: Request) -> Health:
    """Return whether the database answers, the bus is read, and every encoder's heart beats."""
    parts: Parts = request.app.state.parts
    try:
        parts.database.check()
    except SQLAlchemyError as error:
        raise AbsentError("the database does not answer") from error
    if parts.live.problem is not None:
        raise AbsentError(f"the bus is not read: {parts.live.problem}")
    lost = [one for one in (parts.live.report.nodes if parts.live.report else ()) if one.is_lost]
    if lost:
        raise AbsentError(f"no heartbeat of node {', '.join(str(one.node) for one in lost)}")
    return Health()


@router.get("/metrics", operation_id="getMetrics", response_class=Response, include_in_schema=False)
def metrics(request: Request) -> Response:
    """Return figures for Prometheus."""
    from service.metrics import exposition

    content, kind = exposition(request.app.state.parts, request.app.state.calls)
    return Response(content, media_type=kind)
