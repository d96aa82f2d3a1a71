"""Parts of several routes: pages of lists, conditions, and problems that every call may answer."""

from __future__ import annotations

from typing import Annotated, Generic, TypeVar

from fastapi import Header, Query, Request
from fastapi.exceptions import RequestValidationError
from pydantic import BaseModel

from omnimate.service.errors import MediaTypeError
from omnimate.service.problems import documented
from omnimate.service.store.tables import CURSOR_PATTERN

T = TypeVar("T")

ALWAYS = documented(400, 401, 403, 404, 409, 413, 415, 422, 429, 503)
Limit = Annotated[int, Query(ge=1, le=200, description="The largest number of items of the page.")]
After = Annotated[
    str | None,
    Query(
        description="The value of `next` in the page before this one.",
        max_length=120,
        json_schema_extra={"pattern": CURSOR_PATTERN},
    ),
]
IfMatch = Annotated[str, Header(description="The ETag of the version that is changed, or * for any version.")]


class Page(BaseModel, Generic[T]):
    """A page of a list, newest first."""

    items: list[T]
    next: str | None


class Done(BaseModel):
    """A confirmation."""

    done: str


def require_type(request: Request, types: tuple[str, ...], of: str) -> None:
    """Refuse a body that is of none of these types by its header; a body without one is of the first.

    The message of the MediaTypeError says what to send by `of`.
    """
    kind = request.headers.get("content-type", types[0]).partition(";")[0].strip().lower()
    if kind not in types:
        raise MediaTypeError(
            f"content type {kind!r}; send the header Content-Type: {types[0]} with {of} (curl --data-binary)"
        )


def refuse_unknown_query(request: Request) -> None:
    """Refuse query parameters that the document of a call does not have, such as a filter with a typo."""
    if request.query_params:
        calls = request.app.openapi()["paths"].get(request.scope["route"].path, {})
        parameters = calls.get(request.method.lower(), {}).get("parameters", [])
        known = {parameter["name"] for parameter in parameters if parameter["in"] == "query"}
        unknown = [name for name in request.query_params if name not in known]
        if unknown:
            raise RequestValidationError(
                [{"type": "extra_forbidden", "loc": ("query", name), "input": name} for name in unknown]
            )


def etag(content: object) -> str:
    """Return an ETag."""
    return f'"{content}"'


def expected_version(if_match: str) -> str | None:
    """Return the version that If-Match names; None for `*`."""
    tag = if_match.strip().removeprefix("W/").strip('"')
    return None if tag == "*" else tag
