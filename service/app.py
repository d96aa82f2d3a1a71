"""The application: routes, problems, limits and the page, around parts that start and stop with it."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi
from fastapi.responses import FileResponse
from fastapi.staticfiles import StaticFiles

from service import problems
from service.limits import Limits
from service.metrics import Calls, Measured
from service.routes import diagnoses, health, recordings, robot, umbmark, vehicles

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable

    from service.parts import Parts

PAGE = Path(__file__).with_name("page")
ABOUT = (
    "Calibration, recordings and diagnoses of CANopen robots. SI units throughout: metres, radians, seconds. "
    "Every error is a problem detail (RFC 9457). An Idempotency-Key on a POST makes it happen once."
)


def create_app(parts: Parts) -> FastAPI:
    """Return the application of parts, which it starts and stops."""
    app = FastAPI(
        title="omnimate", version="1", description=ABOUT, lifespan=_lifespan, docs_url=None, redoc_url=None,
        strict_content_type=True,
    )  # fmt: skip
    app.state.parts, app.state.calls = parts, Calls()
    problems.install(app)
    app.add_middleware(Measured, calls=app.state.calls)
    app.add_middleware(Limits, settings=parts.settings)
    for routes in (umbmark, vehicles, recordings, diagnoses, robot, health):
        app.include_router(routes.router)
    app.mount("/page", StaticFiles(directory=PAGE), name="page")
    app.get("/", include_in_schema=False)(_page("index.html"))
    app.get("/docs", include_in_schema=False)(_page("docs.html"))
    app.openapi = lambda: _openapi(app)  # type: ignore[method-assign]  # FastAPI's own way to extend it
    return app


@asynccontextmanager
async def _lifespan(app: FastAPI) -> AsyncIterator[None]:
    parts: Parts = app.state.parts
    parts.hub.open(asyncio.get_running_loop())
    parts.live.start()
    parts.worker.start()
    try:
        yield
    finally:
        await asyncio.to_thread(_close, parts)


def _close(parts: Parts) -> None:
    parts.hub.close()
    parts.live.close()
    parts.worker.close()
    parts.database.close()


def _page(name: str) -> Callable[[], Awaitable[FileResponse]]:
    async def page() -> FileResponse:
        return FileResponse(PAGE / name)

    return page


def _openapi(app: FastAPI) -> dict[str, Any]:
    """Return the document, in which every problem is described once."""
    if app.openapi_schema is None:
        document = get_openapi(
            title=app.title,
            version=app.version,
            description=ABOUT,
            routes=app.routes,
            openapi_version="3.1.0",
        )
        schemas = document.setdefault("components", {}).setdefault("schemas", {})
        described = problems.Problem.model_json_schema(ref_template="#/components/schemas/{model}")
        schemas |= described.pop("$defs", {})
        schemas["Problem"] = described
        for unused in ("HTTPValidationError", "ValidationError"):
            schemas.pop(unused, None)
        document["components"]["securitySchemes"] = {"key": {"type": "http", "scheme": "bearer"}}
        document["security"] = [{"key": []}, {}]
        app.openapi_schema = document
    return app.openapi_schema
