"""The application: routes, problem details, limits, metrics and the page."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fastapi import Depends, FastAPI
from fastapi.responses import FileResponse
from fastapi.staticfiles import StaticFiles
from starlette.requests import ClientDisconnect

from omnimate.service import problems
from omnimate.service.limits import Limits
from omnimate.service.metrics import CallTimer, call_histogram, operation_id
from omnimate.service.request_log import RequestIds
from omnimate.service.routes import (
    diagnoses,
    fleet_results,
    fleets,
    health,
    learned,
    recordings,
    robot,
    umbmark_sessions,
    vehicles,
)
from omnimate.service.routes.common import refuse_unknown_query

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable

    from fastapi import Request
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

    from omnimate.service.components import Components


PAGE = Path(__file__).with_name("page")
ROUTES = (
    umbmark_sessions,
    vehicles,
    recordings,
    learned,
    diagnoses,
    fleets,
    fleet_results,
    robot,
    health,
)
DESCRIPTION = (
    "Calibration, recordings and diagnoses of CANopen robots and their fleets. All values are in SI units: "
    "metres, radians, seconds. Every error is a problem detail (RFC 9457). A POST with an Idempotency-Key is "
    "carried out once, however often it is repeated."
)


def create_app(components: Components) -> FastAPI:
    """Return the application of these components, which it starts and closes."""
    app = FastAPI(
        title="omnimate", version="1", description=DESCRIPTION, lifespan=_lifespan, docs_url=None,
        redoc_url=None, strict_content_type=True, generate_unique_id_function=operation_id,
    )  # fmt: skip
    app.state.components, app.state.call_seconds = components, call_histogram()
    problems.install(app)
    app.add_middleware(CallTimer, seconds=app.state.call_seconds)
    app.add_middleware(HeadCalls)
    app.add_middleware(Limits, settings=components.settings)
    app.add_middleware(RequestIds)
    for routes in ROUTES:
        app.include_router(routes.router, dependencies=[Depends(refuse_unknown_query)])
    app.mount("/page", StaticFiles(directory=PAGE), name="page")
    app.add_route("/", _page("index.html"), include_in_schema=False)
    app.add_route("/docs", _page("docs.html"), include_in_schema=False)
    app.openapi = lambda: _openapi(app)  # type: ignore[method-assign]  # FastAPI's own way to extend it
    return app


@asynccontextmanager
async def _lifespan(app: FastAPI) -> AsyncIterator[None]:
    components: Components = app.state.components
    components.start(asyncio.get_running_loop())
    try:
        yield
    finally:
        await asyncio.to_thread(components.close)


def _page(name: str) -> Callable[[Request], Awaitable[FileResponse]]:
    async def page(_request: Request) -> FileResponse:
        return FileResponse(PAGE / name)

    return page


def _openapi(app: FastAPI) -> dict[str, Any]:
    """Return the OpenAPI document, in which the problem detail is described once."""
    if app.openapi_schema is not None:
        return app.openapi_schema
    document = FastAPI.openapi(app)
    schemas = document["components"]["schemas"]
    problem = problems.Problem.model_json_schema(ref_template="#/components/schemas/{model}")
    schemas |= problem.pop("$defs")
    schemas["Problem"] = problem
    document["components"]["securitySchemes"] = {"key": {"type": "http", "scheme": "bearer"}}
    document["security"] = [{"key": []}, {}]
    return document


class HeadCalls:
    """An ASGI application in front of another one, which answers HEAD by the headers of GET."""

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Forward a call; HEAD as GET."""
        if scope["type"] != "http" or scope["method"] != "HEAD":
            await self.app(scope, receive, send)
            return

        async def send_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                await send(message)
                await send({"type": "http.response.body", "body": b""})
            elif message.get("more_body"):  # a stream, which might never end
                raise ClientDisconnect

        with suppress(ClientDisconnect):
            await self.app({**scope, "method": "GET"}, receive, send_headers)
