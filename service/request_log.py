"""The log, as JSON where that is asked for, and the id of each request, which its lines and answers have."""

from __future__ import annotations

import json
import logging
import re
import secrets
import time
from contextvars import ContextVar
from datetime import UTC, datetime
from typing import TYPE_CHECKING

from starlette.datastructures import Headers, MutableHeaders

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

HEADER = "X-Request-ID"
HARMLESS = re.compile(r"[A-Za-z0-9._-]{1,128}")  # neither ends a line nor quotes anything
request_id: ContextVar[str | None] = ContextVar("request_id", default=None)
_log = logging.getLogger(__name__)


class RequestIds:
    """An ASGI application in front of another one, which gives each request its id and logs its answer."""

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Forward a request; its id is the one that the client sent, if that is harmless."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        sent = Headers(scope=scope).get(HEADER, "")
        identity = sent if HARMLESS.fullmatch(sent) else secrets.token_hex(8)
        request_id.set(identity)  # never reset: the server's own answer to an error comes after this call
        began = time.perf_counter()

        def log_answer(status: int) -> None:
            duration = time.perf_counter() - began
            _log.info("%s %s: %d after %.3f s", scope["method"], scope["path"], status, duration)

        async def send_with_id(message: Message) -> None:
            if message["type"] == "http.response.start":
                MutableHeaders(scope=message)[HEADER] = identity
                log_answer(message["status"])  # before it is sent, so that its line is there when it arrives
            await send(message)

        try:
            await self.app(scope, receive, send_with_id)
        except Exception:
            log_answer(500)  # which the server answers
            raise


class JsonLines(logging.Formatter):
    """Formats a record as one line of JSON."""

    def format(self, record: logging.LogRecord) -> str:
        """Return time (ISO 8601, UTC), level, logger and message; request id and traceback if there are."""
        line = {
            "time": datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds"),
            "level": record.levelname.lower(),
            "logger": record.name,
            "message": record.getMessage(),
            "request_id": request_id.get(),
            "exception": self.formatException(record.exc_info) if record.exc_info else None,
        }
        return json.dumps({name: value for name, value in line.items() if value is not None})


def logs_json() -> bool:
    """Return whether this process writes its log as JSON."""
    return any(isinstance(handler.formatter, JsonLines) for handler in logging.getLogger().handlers)


def log_as_json() -> None:
    """Write what this process logs to stderr as JSON: every request, and the warnings of all libraries."""
    handler = logging.StreamHandler()
    handler.setFormatter(JsonLines())
    logging.basicConfig(handlers=[handler], level=logging.WARNING)
    logging.getLogger("omnimate").setLevel(logging.INFO)
    logging.captureWarnings(True)
