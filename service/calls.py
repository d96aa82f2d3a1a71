"""A call of the REST interface: the application's components, who calls, and how a change is carried out."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, TypeVar

from fastapi import Depends, Header, Request
from fastapi.responses import Response
from pydantic import BaseModel
from starlette.concurrency import run_in_threadpool

from omnimate.service.access import Caller, require_role
from omnimate.service.idempotency import (
    Answer,
    IdempotentRequest,
    act_once,
    digest_of,
    replayed,
    storable_key,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from sqlalchemy.orm import Session

    from omnimate.service.components import Components

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Call:
    """What every route works with.

    Attributes:
        components: The components of the application.
        caller: Who calls.
        key: The Idempotency-Key; None where there is none.
        name: Method and path.
    """

    components: Components
    caller: Caller
    key: str | None
    name: str

    def change(self, body: BaseModel | bytes | None, act: Callable[[Session], Answer]) -> Response:
        """Carry out a change in one transaction; with an Idempotency-Key, once only.

        Raises:
            StateError: the Idempotency-Key was used for another request.
        """
        return self._act(self._request(body), act)

    def compute_and_change(
        self, body: BaseModel | bytes | None, compute: Callable[[], T], act: Callable[[Session, T], Answer]
    ) -> Response:
        """Compute outside of any transaction, then carry out a change in a short one, as `change`.

        Args:
            body: The body of the request.
            compute: Reads and computes what the change needs; not called for a repeated request.
            act: Checks that what was read has not changed meanwhile, and makes the change.

        Raises:
            StateError: the Idempotency-Key was used for another request.
        """
        request = self._request(body)
        response = replayed(self.components.database, request) if request is not None else None
        if response is not None:
            return response
        computed = compute()
        return self._act(request, lambda db: act(db, computed))

    def _request(self, body: BaseModel | bytes | None) -> IdempotentRequest | None:
        if self.key is None:
            return None
        return IdempotentRequest(self.caller.name, self.key, self.name, digest_of(body))

    def _act(self, request: IdempotentRequest | None, act: Callable[[Session], Answer]) -> Response:
        database = self.components.database
        if request is not None:
            return act_once(database, request, act)
        with database.writing() as db:
            answer = act(db)
            db.flush()
        return answer.as_response()


async def _reading(
    request: Request, authorization: Annotated[str | None, Header(include_in_schema=False)] = None
) -> Call:
    components: Components = request.app.state.components
    caller = components.callers.remembered(authorization)
    if caller is None:
        caller = await run_in_threadpool(components.callers.identify, components.database, authorization)
    return Call(components, caller, None, f"{request.method} {request.url.path}")


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
    require_role(call.caller, "operate")
    return replace(call, key=storable_key(idempotency_key) if idempotency_key else None)


Reading = Annotated[Call, Depends(_reading)]
Operating = Annotated[Call, Depends(_operating)]
