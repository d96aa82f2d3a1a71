"""Problem details, RFC 9457: the answer to every error, in terms of this service, and its form in OpenAPI."""

from __future__ import annotations

import errno
import json
import logging
import sqlite3
from http import HTTPStatus
from typing import TYPE_CHECKING, Any

from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from pydantic import BaseModel, Field
from sqlalchemy.exc import OperationalError
from sqlalchemy.exc import TimeoutError as PoolTimeout
from starlette.exceptions import HTTPException
from starlette.routing import compile_path

from omnimate.service.errors import (
    InvalidValueError,
    MediaTypeError,
    ServiceError,
    StateError,
    UnavailableError,
)
from omnimate.service.request_log import HEADER, request_id
from omnimate.vehicle.errors import OmnimateError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from fastapi import FastAPI, Request

MEDIA = "application/problem+json"
DISK_FULL = "the disk is full, and nothing was changed; free space on it, then try again"
SHOWN_ERRORS = 20
MAX_SHOWN_LENGTH = 60  # characters of a value that is shown again

_NUMBER = "a number"
_WHOLE = "a whole number"
_TEXT = "text"
_EXPECTED = {  # by pydantic's type of the error, with what its context holds
    "literal_error": "{expected}",
    "greater_than": "more than {gt}",
    "greater_than_equal": "{ge} or more",
    "less_than": "less than {lt}",
    "less_than_equal": "{le} or less",
    "finite_number": "a finite number",
    "float_parsing": _NUMBER,
    "float_type": _NUMBER,
    "int_parsing": _WHOLE,
    "int_type": _WHOLE,
    "int_from_float": _WHOLE,
    "int_parsing_size": _WHOLE,
    "bool_parsing": "true or false",
    "bool_type": "true or false",
    "string_type": _TEXT,
    "string_too_short": "{min_length} characters or more",
    "string_too_long": "{max_length} characters at most",
    "string_pattern_mismatch": "text of the form {pattern}",
    "list_type": "a list",
    "too_short": "{min_length} or more of them",
    "too_long": "{max_length} of them at most",
    "model_attributes_type": "a JSON object",
    "model_type": "a JSON object",
    "dict_type": "a JSON object",
    "date_from_datetime_parsing": "a date as YYYY-MM-DD",
    "date_parsing": "a date as YYYY-MM-DD",
}
_log = logging.getLogger(__name__)


class Detail(BaseModel):
    """A field of the request that is wrong."""

    where: str = Field(examples=["body.side"])
    problem: str = Field(examples=["0.1; expected 0.2 or more"])


class Problem(BaseModel):
    """A problem detail, RFC 9457."""

    type: str = Field("about:blank", examples=["about:blank"])
    title: str = Field(examples=["Not in this state"])
    status: int = Field(examples=[409])
    detail: str = Field(
        examples=["session 9b1c is collecting and cannot take 'accept'; possible now: sample, solve"]
    )
    possible: list[str] | None = Field(
        None, description="The calls that the present state of a session allows."
    )
    errors: list[Detail] | None = Field(None, description="The fields of the request that are wrong.")
    request_id: str | None = Field(None, description="X-Request-ID of the answer; the log names it, too.")


def documented(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """Return the description of a call's problems for OpenAPI, by their HTTP status."""
    return {
        status: {
            "description": HTTPStatus(status).phrase,
            "content": {MEDIA: {"schema": {"$ref": "#/components/schemas/Problem"}}},
        }
        for status in statuses
    }


def problem_response(
    status: int,
    title: str,
    detail: str,
    *,
    possible: tuple[str, ...] | None = None,
    errors: list[dict[str, str]] | None = None,
    headers: dict[str, str] | None = None,
) -> JSONResponse:
    """Return a problem detail as a response."""
    identity = request_id.get()
    if identity is not None:
        headers = {**(headers or {}), HEADER: identity}
    body = {"title": title, "status": status, "detail": detail}
    more = {"possible": possible, "errors": errors, "request_id": identity}
    shown = Problem.model_validate(body | more).model_dump(exclude_none=True)
    return JSONResponse(shown, status, headers, MEDIA)


def install(app: FastAPI) -> None:
    """Let an application answer every error with a problem detail."""
    app.add_exception_handler(OmnimateError, _of_rooms)
    app.add_exception_handler(RequestValidationError, _of_validation)
    app.add_exception_handler(HTTPException, _of_http)
    app.add_exception_handler(OperationalError, _of_database)
    app.add_exception_handler(PoolTimeout, _of_database)
    app.add_exception_handler(OSError, _of_files)
    app.add_exception_handler(Exception, _unexpected)


def response_of(error: ServiceError) -> JSONResponse:
    """Return the answer to an error of the service."""
    possible = error.possible if isinstance(error, StateError) else None
    errors = (
        [{"where": error.where, "problem": error.problem}] if isinstance(error, InvalidValueError) else None
    )
    return problem_response(
        error.status, error.title, str(error), possible=possible, errors=errors, headers=error.headers
    )


async def _of_rooms(_request: Request, error: Exception) -> JSONResponse:
    """Answer an error of this room, or of another one, which explains what is wrong with the request."""
    if isinstance(error, ServiceError):
        return response_of(error)
    return problem_response(422, "Not usable", str(error))


async def _of_validation(request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, RequestValidationError)
    missing = {invalid["loc"] for invalid in error.errors() if invalid["type"] == "missing"}
    kind = request.headers.get("content-type")
    if any(isinstance(invalid["input"], bytes) for invalid in error.errors()):  # a body that was not parsed
        sent = "no Content-Type" if kind is None else f"content type {kind!r}"
        return response_of(
            MediaTypeError(f"{sent}; send the header Content-Type: application/json with the body")
        )
    if ("header", "if-match") in missing:
        return problem_response(
            428, "If-Match is missing", "send If-Match with the ETag of what you saw, or * for any version"
        )
    errors = [
        {"where": _where(wrong["loc"]), "problem": _problem(wrong)} for wrong in error.errors()[:SHOWN_ERRORS]
    ]
    detail = "; ".join(f"{wrong['where']}: {wrong['problem']}" for wrong in errors)
    return problem_response(422, "Not as expected", detail[:1000], errors=errors)


async def _of_http(request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, HTTPException)
    title = HTTPStatus(error.status_code).phrase
    if error.status_code == 400 and error.__cause__ is not None:  # FastAPI could not parse a body
        return response_of(InvalidValueError("body", "no JSON; expected JSON (RFC 8259) in UTF-8"))
    if error.status_code == 405:
        return problem_response(
            405,
            title,
            f"{request.method} is not among {_allowed(request)}",
            headers={"Allow": _allowed(request)},
        )
    explained = error.detail != title
    detail = error.detail if explained else f"{title}; see /openapi.json for the calls that there are"
    return problem_response(error.status_code, title, detail, headers=dict(error.headers or {}))


def _allowed(request: Request) -> str:
    """Return all methods that the OpenAPI document lists for a path."""
    paths = request.app.openapi()["paths"].items()
    matching = (calls for path, calls in paths if compile_path(path)[0].match(request.url.path))
    methods = {method.upper() for calls in matching for method in calls}
    return ", ".join(sorted(methods | {"HEAD"} if "GET" in methods else methods))


async def _of_database(_request: Request, error: Exception) -> JSONResponse:
    _log.error("the database did not answer: %s", error)
    cause = getattr(error, "orig", None)
    full = (
        getattr(cause, "sqlite_errorcode", None) == sqlite3.SQLITE_FULL
        or getattr(cause, "sqlstate", None) == "53100"  # PostgreSQL's disk_full
    )
    return response_of(UnavailableError(DISK_FULL if full else "the database did not answer; try again"))


async def _of_files(request: Request, error: Exception) -> JSONResponse:
    if getattr(error, "errno", None) not in {errno.ENOSPC, errno.EDQUOT}:
        return await _unexpected(request, error)
    _log.error("a file was not written: %s", error)
    return response_of(UnavailableError(DISK_FULL))


async def _unexpected(_request: Request, error: Exception) -> JSONResponse:
    _log.error("an error in the service itself", exc_info=error)
    return problem_response(500, "An error of ours", "an error in the service itself; its log says more")


def _where(location: Sequence[str | int]) -> str:
    """Return a field's name; pydantic adds the names of its classes where there are several forms."""
    return ".".join(str(part) for part in location if not (isinstance(part, str) and part[:1].isupper()))


def _problem(error: Mapping[str, Any]) -> str:
    kind, context = error["type"], error.get("ctx", {})
    if kind == "missing":
        return "missing"
    if kind == "extra_forbidden":
        return "unknown; leave it out, or see /openapi.json for the fields that there are"
    if kind == "json_invalid":
        return f"no JSON: {context['error']}"
    if kind == "value_error":  # of a validator of this service
        return str(context["error"])
    value = error["input"]
    given = json.dumps(value) if value is None or isinstance(value, bool) else repr(value)  # as in JSON
    shown = given if len(given) <= MAX_SHOWN_LENGTH else f"{given[:MAX_SHOWN_LENGTH]}..."
    limits = {name: f"{value:g}" if isinstance(value, float) else value for name, value in context.items()}
    expected = _EXPECTED.get(kind, f"another value ({kind})").format(**limits)
    return f"{shown}; expected {expected}"
