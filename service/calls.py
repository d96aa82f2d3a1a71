"""A call of the REST interface: the application's components, who calls, and how a change is carried out."""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, TypeVar

from fastapi import Depends, Header, Request
from fastapi.responses import Response
from pydantic import BaseModel
from sqlalchemy.exc import IntegrityError, SQLAlchemyError
from starlette.concurrency import run_in_threadpool

from omnimate.service.access import REMEMBERED_TIME, Caller
from omnimate.service.errors import AuthenticationError, ForbiddenError, StateError
from omnimate.service.store.tables import AnswerRow

if TYPE_CHECKING:
    from collections.abc import Callable

    from sqlalchemy.orm import Session

    from omnimate.service.components import Components
    from omnimate.service.store.database import Database


JSON = "application/json"
MAX_KEY_LENGTH = 200


class Answer(Response):
    """The answer to a request that changes something, as JSON."""

    media_type = JSON

    def __init__(self, content: BaseModel, status: int = 200, headers: dict[str, str] | None = None) -> None:
        super().__init__(content.model_dump_json(), status, headers)
        self.additional = headers or {}  # to the headers of every answer


def digest_of(body: BaseModel | bytes | None) -> str:
    """Return a hash of a request's body."""
    content = body.model_dump_json().encode() if isinstance(body, BaseModel) else body or b""
    return hashlib.sha256(content).hexdigest()


def storable(text: str) -> str:
    """Return a client's key, or the name of its call, as it fits into the table, however long it is."""
    return text if len(text) <= MAX_KEY_LENGTH else hashlib.sha256(text.encode()).hexdigest()


def act_once(database: Database, request: AnswerRow | None, act: Callable[[Session], Answer]) -> Response:
    """Carry out a request in one transaction, or answer as before where it was carried out already.

    It has a row, without its answer, where it may be repeated; StateError where its key was used for another.
    """
    if request is None:
        with database.writing() as db:
            return act(db)
    try:
        with database.writing() as db:
            response = replayed(db, request)
            if response is not None:
                return response
            db.add(request)
            db.flush()
            answer = act(db)
            request.status, request.headers = answer.status_code, answer.additional
            request.body = bytes(answer.body).decode()
    except IntegrityError:  # the same request came twice at once, and the other one was first
        with database.reading() as db:
            response = replayed(db, request)
        if response is None:
            raise
        return response
    return answer


def replayed(db: Session, request: AnswerRow) -> Response | None:
    """Return the answer to a request that was carried out already; None where it was not."""
    before = db.get(AnswerRow, (request.caller, request.key))
    if before is None:
        return None
    if (before.call, before.digest) != (request.call, request.digest):
        raise StateError(
            f"Idempotency-Key {request.key!r} was used for another request; send a new key with a new request"
        )
    headers = before.headers | {"Idempotency-Replayed": "true"}
    return Response(before.body, before.status, headers, JSON)


T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Call:
    """What every route works with."""

    components: Components
    caller: Caller
    key: str | None  # Idempotency-Key
    name: str  # method, path and query; a hash where that is long
    authorization: str | None = None  # its header

    def is_still_allowed(self) -> bool:
        """Return whether the key of the caller is valid now; also where the database does not answer."""
        try:
            self.components.callers.identify(self.components.database, self.authorization)
        except AuthenticationError:
            return False
        except SQLAlchemyError:
            pass  # the key was valid before
        return True

    def change(self, body: BaseModel | bytes | None, act: Callable[[Session], Answer]) -> Response:
        """Carry out a change in one transaction; with an Idempotency-Key, once only, as `act_once`."""
        return act_once(self.components.database, self._request(body), act)

    def compute_and_change(
        self, body: BaseModel | bytes | None, compute: Callable[[], T], act: Callable[[Session, T], Answer]
    ) -> Response:
        """Compute outside of any transaction, then carry out a change in a short one, as `change`.

        `compute` is not called for a repeated request; `act` checks that what it read is unchanged.
        """
        request, database = self._request(body), self.components.database
        if request is not None:
            with database.reading() as db:
                response = replayed(db, request)
            if response is not None:
                return response
        computed = compute()
        return act_once(database, request, lambda db: act(db, computed))

    def _request(self, body: BaseModel | bytes | None) -> AnswerRow | None:
        """Return the row of a request with an Idempotency-Key, which two callers may share."""
        if self.key is None:
            return None
        return AnswerRow(caller=self.caller.name, key=self.key, call=self.name, digest=digest_of(body))


Authorization = Annotated[str | None, Header(include_in_schema=False)]


async def _reading(request: Request, authorization: Authorization = None) -> Call:
    return await _call(request, authorization, REMEMBERED_TIME)


async def _stopping(request: Request, authorization: Authorization = None) -> Call:
    """As `_reading`, but without the database for a key that was used since the service started."""
    return await _call(request, authorization, math.inf)


async def _call(request: Request, authorization: str | None, age: float) -> Call:
    """Return the call of a client that was identified at most `age` [s] ago, or is by the database."""
    components: Components = request.app.state.components
    caller = components.callers.remembered(authorization, age)
    if caller is None:
        caller = await run_in_threadpool(components.callers.identify, components.database, authorization)
    query = f"?{request.url.query}" if request.url.query else ""
    name = storable(f"{request.method} {request.url.path}{query}")
    return Call(components, caller, None, name, authorization)


async def _operating(
    call: Annotated[Call, Depends(_reading)],
    idempotency_key: Annotated[
        str | None,
        Header(
            description="A text of the client's choice. A request that is repeated with the same key is "
            "carried out once, and answered alike."
        ),
    ] = None,
) -> Call:
    if call.caller.role != "operate":
        raise ForbiddenError(
            "this key may only read; moving the robot or changing anything needs the role operate"
        )
    return replace(call, key=storable(idempotency_key) if idempotency_key else None)


Reading = Annotated[Call, Depends(_reading)]
Operating = Annotated[Call, Depends(_operating)]
Stopping = Annotated[Call, Depends(_stopping)]
