"""Health, readiness, and metrics for Prometheus."""

from __future__ import annotations

from fastapi import APIRouter, Request
from fastapi.responses import Response
from pydantic import BaseModel
from sqlalchemy.exc import SQLAlchemyError

from omnimate.service.components import Components
from omnimate.service.errors import UnavailableError
from omnimate.service.problems import documented

router = APIRouter(tags=["health"])


class Health(BaseModel):
    """A confirmation that the service is healthy."""

    status: str = "ok"


@router.get("/healthz")
async def get_health() -> Health:
    """Return ok as long as the process is alive."""
    return Health()


@router.get("/readyz", responses=documented(503))
def get_readiness(request: Request) -> Health:
    """Return ok if the database and files can be written, the bus is read, and no encoder is lost."""
    components: Components = request.app.state.components
    try:
        components.database.check()
    except SQLAlchemyError as error:
        raise UnavailableError("the database does not answer") from error
    try:
        components.recordings.check()
    except SQLAlchemyError as error:
        raise UnavailableError(
            "the database cannot be written; its disk may be full, or another program may lock it"
        ) from error
    except OSError as error:
        raise UnavailableError(f"recordings cannot be written to --fleets: {error.strerror}") from error
    status = components.robot.status
    if status.problem is not None:
        raise UnavailableError(f"the bus is not read: {status.problem}")
    lost = [str(node.node) for node in status.report.nodes if node.is_lost] if status.report else []
    if lost:
        raise UnavailableError(f"no heartbeat of node {', '.join(lost)}")
    return Health()


@router.get("/metrics", response_class=Response, include_in_schema=False)
def get_metrics(request: Request) -> Response:
    """Return metrics for Prometheus."""
    from omnimate.service.metrics import exposition

    content, kind = exposition(request.app.state.components, request.app.state.call_seconds)
    return Response(content, media_type=kind)
