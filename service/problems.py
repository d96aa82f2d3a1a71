"""Every error as a problem detail, RFC 9457, and how each is documented."""

from __future__ import annotations

import logging
from http import HTTPStatus
from typing import TYPE_CHECKING, Any

from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from pydantic import BaseModel, Field
from sqlalchemy.exc import OperationalError
from sqlalchemy.exc import TimeoutError as PoolTimeout
from starlette.exceptions import HTTPException
from starlette.routing import compile_path

from service.errors import ServiceError, StateError, ValueProblem
from vehicle.errors import OmnimateError

if TYPE_CHECKING:
    from fastapi import FastAPI, Request

MEDIA = "application/problem+json"
_log = logging.getLogger(__name__)


class Detail(BaseModel):
    """One thing that is wrong with what was sent."""

    where: str = Field(examples=["body.side"])
    problem: str = Field(examples=["Input should be greater than or equal to 0.2"])


class Problem(BaseModel):
    """A problem detail, RFC 9457."""

    type: str = Field("about:blank", examples=["about:blank"])
    title: str = Field(examples=["Not in this state"])
    status: int = Field(examples=[409])
    detail: str = Field(
        examples=["session 9b1c is collecting and cannot take 'accept'; possible now: sample, solve"]
    )
    possible: list[str] | None = Field(None, description="calls that the state allows")
    errors: list[Detail] | None = Field(None, description="what is wrong with what was sent")


def documented(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """Return how OpenAPI describes the problems of a call."""
    return {
        status: {
            "description": HTTPStatus(status).phrase,
            "content": {MEDIA: {"schema": {"$ref": "#/components/schemas/Problem"}}},
        }
        for status in statuses
    }


def answer(
    status: int,
    title: str,
    detail: str,
    *,
    possible: tuple[str, ...] | None = None,
    errors: list[dict[str, str]] | None = None,
    headers: dict[str, str] | None = None,
) -> JSONResponse:
    """Return a problem as a response."""
    body: dict[str, Any] = {"type": "about:blank", "title": title, "status": status, "detail": detail}
    if possible is not None:
        body["possible"] = list(possible)
    if errors is not None:
        body["errors"] = errors
    return JSONResponse(body, status, headers, MEDIA)


def install(app: FastAPI) -> None:
    """Have an application answer every error with a problem detail."""
    app.add_exception_handler(ServiceError, _of_service)
    app.add_exception_handler(OmnimateError, _of_rooms)
    app.add_exception_handler(RequestValidationError, _of_validation)
    app.add_exception_handler(HTTPException, _of_http)
    app.add_exception_handler(OperationalError, _of_database)
    app.add_exception_handler(PoolTimeout, _of_database)
    app.add_exception_handler(Exception, _unexpected)


async def _of_service(_request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, ServiceError)
    possible = error.possible if isinstance(error, StateError) else None
    errors = [{"where": error.where, "problem": error.problem}] if isinstance(error, ValueProblem) else None
    return answer(
        error.status, error.title, str(error), possible=possible, errors=errors, headers=error.headers
    )


async def _of_rooms(_request: Request, error: Exception) -> JSONResponse:
    """Say what a room of the project found wrong with what was sent."""
    return answer(422, "Not usable", str(error))


async def _of_validation(_request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, RequestValidationError)
    errors = [
        {"where": ".".join(str(part) for part in one["loc"]), "problem": str(one["msg"])}
        for one in error.errors()[:20]
    ]
    if any(one["type"] == "missing" and one["loc"] == ("header", "if-match") for one in error.errors()):
        return answer(428, "If-Match is missing", "send If-Match with the ETag of what you saw, or * for any")
    detail = "; ".join(f"{one['where']}: {one['problem']}" for one in errors)
    return answer(422, "Not as expected", detail[:1000], errors=errors)


async def _of_http(request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, HTTPException)
    title = HTTPStatus(error.status_code).phrase
    if error.status_code == 405:
        return answer(
            405,
            title,
            f"{request.method} is not among {_allowed(request)}",
            headers={"Allow": _allowed(request)},
        )
    own = error.detail != title
    detail = error.detail if own else f"{title}; see /openapi.json for the calls that there are"
    return answer(error.status_code, title, detail, headers=dict(error.headers or {}))


def _allowed(request: Request) -> str:
    """Return all methods that the document lists for a path; whichever route has them."""
    paths = request.app.openapi()["paths"].items()
    matching = (calls for path, calls in paths if compile_path(path)[0].match(request.url.path))
    return ", ".join(sorted({method.upper() for calls in matching for method in calls}))


async def _of_database(_request: Request, error: Exception) -> JSONResponse:
    _log.error("the database did not answer: %s", error)
    return answer(503, "Not now", "the database did not answer; try again", headers={"Retry-After": "2"})


async def _unexpected(_request: Request, error: Exception) -> JSONResponse:
    _log.error("unexpected", exc_info=error)
    return answer(
        500, "An error of ours", "something went wrong that should not have; the service's log says what"
    )
