"""What several routes share: pages of lists, conditions, how problems are documented."""

from __future__ import annotations

from typing import Annotated, Generic, TypeVar

from fastapi import Header, Query
from pydantic import BaseModel

from service.problems import documented
from service.umbmark.models import Id

T = TypeVar("T")

ALWAYS = documented(400, 401, 403, 409, 413, 422, 429, 503)
Limit = Annotated[int, Query(ge=1, le=200, description="items of a page")]
After = Annotated[Id | None, Query(description="`next` of the page before")]
IfMatch = Annotated[str, Header(description="ETag of what is to be changed, or *")]


class Page(BaseModel, Generic[T]):
    """A page of a list, newest first."""

    items: list[T]
    next: str | None


class Done(BaseModel):
    """That something was done."""

    done: str


def etag(content: object) -> str:
    """Return an ETag."""
    return f'"{content}"'


def condition(if_match: str) -> str | None:
    """Return what If-Match names; None for `*`."""
    tag = if_match.strip().removeprefix("W/").strip('"')
    return None if tag == "*" else tag
