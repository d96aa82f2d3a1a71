"""The limits of requests: the size of their body, the site that they come from, and their rate."""

from __future__ import annotations

import re
import time
from collections import OrderedDict
from typing import TYPE_CHECKING

from fastapi import HTTPException
from starlette.datastructures import Headers, MutableHeaders

from omnimate.service.errors import (
    ForbiddenError,
    MediaTypeError,
    ServiceError,
    TooLargeError,
    TooManyCallsError,
)
from omnimate.service.problems import response_of

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

    from omnimate.service.settings import Settings

BURST_TIME = 3.0  # [s] of calls at the allowed rate that may come at once
REMEMBERED_CALLERS = 10_000
UPLOADS = re.compile(r"/v1/(recordings|fleets/[^/]+/recordings)/?")
STOPS = re.compile(r"/v1/(robot/stop|umbmark/sessions/[^/]+/abort)/?")
LOOPBACK = {"localhost", "127.0.0.1", "[::1]", "::1"}
HEADERS = {
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "content-security-policy": "default-src 'self'; img-src 'self' data: blob:; frame-src 'self' blob:; "
    "frame-ancestors 'self'; base-uri 'none'; form-action 'self'",
}


class Limits:
    """An ASGI application in front of another one, which refuses requests beyond the limits."""

    def __init__(self, app: ASGIApp, settings: Settings) -> None:
        self.app = app
        self._settings = settings
        self._buckets: OrderedDict[str, tuple[float, float]] = OrderedDict()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Refuse a request, or forward it."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        try:
            self._check(scope, Headers(scope=scope))
        except ServiceError as error:
            await response_of(error)(scope, receive, send)
            return
        await self.app(scope, self._limited(scope, receive), _with_headers(send))

    def _check(self, scope: Scope, headers: Headers) -> None:
        """Refuse a request by its headers, or by its caller's rate; the rate never refuses a stop."""
        host, origin = headers.get("host", ""), headers.get("origin")
        if self._settings.is_loopback and host.rsplit(":", 1)[0] not in LOOPBACK and host not in LOOPBACK:
            raise ForbiddenError(f"host {host!r}: this service answers to its loopback names only")
        if origin is not None and origin.partition("//")[2] != host:
            raise ForbiddenError(f"origin {origin!r}: other sites may not call this service")
        encoding = headers.get("content-encoding", "identity").strip().lower()
        if encoding != "identity":
            raise MediaTypeError(
                f"content encoding {encoding!r}; send the body without Content-Encoding, as it is"
            )
        length, limit = headers.get("content-length", "0"), self._limit(scope)
        if not length.isdigit() or int(length) > limit:
            raise TooLargeError(f"{length} bytes; at most {limit} are accepted here")
        stops = scope["method"] == "POST" and STOPS.fullmatch(scope["path"])
        if not self._take_token((scope.get("client") or ("?",))[0]) and not stops:
            raise TooManyCallsError(f"more than {self._settings.rate:g} calls a second; call less often")

    def _limit(self, scope: Scope) -> int:
        upload = scope["method"] == "POST" and UPLOADS.fullmatch(scope["path"])
        return self._settings.upload if upload else self._settings.body

    def _take_token(self, caller: str) -> bool:
        """Take a token from the caller's bucket (token bucket algorithm); return whether there was one."""
        now, rate = time.monotonic(), self._settings.rate
        tokens, then = self._buckets.pop(caller, (rate * BURST_TIME, now))
        tokens = min(rate * BURST_TIME, tokens + rate * (now - then))
        self._buckets[caller] = (tokens - 1.0 if tokens >= 1.0 else tokens, now)
        if len(self._buckets) > REMEMBERED_CALLERS:
            self._buckets.popitem(last=False)
        return tokens >= 1.0

    def _limited(self, scope: Scope, receive: Receive) -> Receive:
        """Return a receiver that refuses a body larger than the limit, whatever its header says."""
        limit, received = self._limit(scope), 0

        async def receive_limited() -> Message:
            nonlocal received
            message = await receive()
            received += len(message.get("body", b""))
            if received > limit:
                raise HTTPException(413, f"more than {limit} bytes, which is the most that is accepted here")
            return message

        return receive_limited


def _with_headers(send: Send) -> Send:
    async def send_with_headers(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            for name, value in HEADERS.items():
                headers.setdefault(name, value)
        await send(message)

    return send_with_headers
