"""Idempotency-Key: a request that is repeated with the same key is carried out once, and answered alike."""

from __future__ import annotations

import hashlib
import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from fastapi.responses import Response
from pydantic import BaseModel
from sqlalchemy.exc import IntegrityError

from omnimate.service.errors import StateError
from omnimate.service.store.tables import AnswerRow

if TYPE_CHECKING:
    from collections.abc import Callable

    from sqlalchemy.orm import Session

    from omnimate.service.store.database import Database

JSON = "application/json"
LONGEST_KEY = 200


@dataclass(frozen=True, slots=True)
class Answer:
    """The answer to a request that changes something.

    Attributes:
        content: The body, as JSON.
        status: The HTTP status.
        headers: Further headers.
    """

    content: BaseModel
    status: int = 200
    headers: dict[str, str] = field(default_factory=dict)

    def as_response(self) -> Response:
        """Return the answer as an HTTP response."""
        return Response(self.content.model_dump_json(), self.status, self.headers, JSON)


@dataclass(frozen=True, slots=True)
class IdempotentRequest:
    """What identifies a request that may be repeated.

    Attributes:
        caller: The name of the caller; two callers may use the same key.
        key: The Idempotency-Key.
        call: Method and path.
        digest: A hash of the body.
    """

    caller: str
    key: str
    call: str
    digest: str


def digest_of(body: BaseModel | bytes | None) -> str:
    """Return a hash of a request's body."""
    content = body.model_dump_json().encode() if isinstance(body, BaseModel) else body or b""
    return hashlib.sha256(content).hexdigest()


def storable_key(key: str) -> str:
    """Return a key that fits into the table, however long the client's key is."""
    return key if len(key) <= LONGEST_KEY else hashlib.sha256(key.encode()).hexdigest()


def act_once(database: Database, request: IdempotentRequest, act: Callable[[Session], Answer]) -> Response:
    """Carry out a request in one transaction, or answer as before where it was carried out already.

    Raises:
        StateError: the key was used for another request.
    """
    try:
        with database.writing() as db:
            response = _replayed(db, request)
            if response is not None:
                return response
            row = _claim_key(db, request)
            answer = act(db)
            db.flush()
            row.status, row.body = answer.status, answer.content.model_dump_json()
            row.headers = answer.headers
        return answer.as_response()
    except IntegrityError:  # the same request came twice at once, and the other one was first
        response = replayed(database, request)
        if response is None:
            raise
        return response


def replayed(database: Database, request: IdempotentRequest) -> Response | None:
    """Return the answer to a request that was carried out already; None where it was not.

    Raises:
        StateError: the key was used for another request.
    """
    with database.reading() as db:
        return _replayed(db, request)


def _claim_key(db: Session, request: IdempotentRequest) -> AnswerRow:
    row = AnswerRow(
        caller=request.caller,
        key=request.key,
        call=request.call,
        digest=request.digest,
        status=0,
        headers={},
        body="",
        created=time.time(),
    )
    db.add(row)
    db.flush()
    return row


def _replayed(db: Session, request: IdempotentRequest) -> Response | None:
    before = db.get(AnswerRow, (request.caller, request.key))
    if before is None:
        return None
    if (before.call, before.digest) != (request.call, request.digest):
        raise StateError(
            f"Idempotency-Key {request.key!r} was used for another request; send a new key with a new request"
        )
    headers = before.headers | {"Idempotency-Replayed": "true"}
    return Response(before.body, before.status, headers, JSON)
