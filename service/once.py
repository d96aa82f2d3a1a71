"""A call: who makes it, and that a POST with an Idempotency-Key happens once."""

from __future__ import annotations

import hashlib
import json
import time
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Annotated

from fastapi import Depends, Header, Request
from fastapi.responses import Response
from pydantic import BaseModel
from sqlalchemy.exc import IntegrityError
from starlette.concurrency import run_in_threadpool

from service.access import Caller, demand
from service.errors import StateError
from service.store.tables import AnswerRow

if TYPE_CHECKING:
    from collections.abc import Callable

    from sqlalchemy.orm import Session

    from service.parts import Parts

JSON = "application/json"
LONGEST = 200


@dataclass(frozen=True, slots=True)
class Answer:
    """What a change is answered with.

    Attributes:
        content: as JSON.
        status: of HTTP.
        headers: beside the usual ones.
    """

    content: BaseModel
    status: int = 200
    headers: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Call:
    """What every route works with.

    Attributes:
        parts: of the application.
        caller: who calls.
        key: Idempotency-Key; None where there is none.
        name: method and path.
    """

    parts: Parts
    caller: Caller
    key: str | None
    name: str

    def once(self, sent: BaseModel | bytes | None, act: Callable[[Session], Answer]) -> Response:
        """Do something in one transaction, or answer as before where this very call was made before.

        Raises:
            StateError: the Idempotency-Key belongs to another call.
        """
        database = self.parts.database
        if self.key is None:
            with database.writing() as db:
                answer = act(db)
                db.flush()
            return _response(answer)
        digest = _digest(sent)
        try:
            with database.writing() as db:
                before = db.get(AnswerRow, (self.caller.name, self.key))
                if before is not None:
                    return self._again(before, digest)
                row = self._claim(db, digest)
                answer = act(db)
                db.flush()
                row.status, row.body = answer.status, answer.content.model_dump_json()
                row.headers = json.dumps(answer.headers)
            return _response(answer)
        except IntegrityError:  # the same call, made twice at once; the other one was first
            with database.reading() as db:
                before = db.get(AnswerRow, (self.caller.name, self.key))
                if before is None:
                    raise
                return self._again(before, digest)

    def _claim(self, db: Session, digest: str) -> AnswerRow:
        row = AnswerRow(
            caller=self.caller.name,
            key=self.key,
            call=self.name,
            digest=digest,
            status=0,
            headers="{}",
            body="",
            created=time.time(),
        )
        db.add(row)
        db.flush()
        return row

    def _again(self, before: AnswerRow, digest: str) -> Response:
        if (before.call, before.digest) != (self.name, digest):
            raise StateError(
                f"Idempotency-Key {self.key!r} was used for another call; take a new key for a new call"
            )
        headers = json.loads(before.headers) | {"Idempotency-Replayed": "true"}
        return Response(before.body, before.status, headers, JSON)


def _digest(sent: BaseModel | bytes | None) -> str:
    content = sent.model_dump_json().encode() if isinstance(sent, BaseModel) else sent or b""
    return hashlib.sha256(content).hexdigest()


def _response(answer: Answer) -> Response:
    return Response(answer.content.model_dump_json(), answer.status, answer.headers, JSON)


async def _reading(
    request: Request, authorization: Annotated[str | None, Header(include_in_schema=False)] = None
) -> Call:
    parts: Parts = request.app.state.parts
    caller = parts.callers.known(authorization)
    if caller is None:
        caller = await run_in_threadpool(parts.callers.look, parts.database, authorization)
    return Call(parts, caller, None, f"{request.method} {request.url.path}")


async def _operating(
    call: Annotated[Call, Depends(_reading)],
    idempotency_key: Annotated[
        str | None, Header(description="the same key twice: done once, answered twice")
    ] = None,
) -> Call:
    demand(call.caller, "operate")
    return replace(call, key=_short(idempotency_key) if idempotency_key else None)


def _short(key: str) -> str:
    """Return a key that fits into the table, whatever its length."""
    return key if len(key) <= LONGEST else hashlib.sha256(key.encode()).hexdigest()


Reading = Annotated[Call, Depends(_reading)]
Operating = Annotated[Call, Depends(_operating)]
