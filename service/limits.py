"""The limits of requests: the size of their body, the site that they come from, and their rate."""

from __future__ import annotations

import re
import time
from collections import OrderedDict
from typing import TYPE_CHECKING

from fastapi import HTTPException

from omnimate.service.problems import problem_response

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

    from omnimate.service.settings import Settings

BURST_TIME = 3.0  # [s] of calls at the allowed rate that may come at once
REMEMBERED_CALLERS = 10_000
UPLOADS = re.compile(r"/v1/(recordings|fleets/[^/]+/recordings)/?")
LOOPBACK = {"localhost", "127.0.0.1", "[::1]", "::1"}
HEADERS = {
    b"x-content-type-options": b"nosniff",
    b"referrer-policy": b"no-referrer",
    b"content-security-policy": b"default-src 'self'; img-src 'self' data: blob:; frame-src 'self' blob:; "
    b"frame-ancestors 'self'; base-uri 'none'; form-action 'self'",
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
        headers = {name: value.decode("latin-1") for name, value in scope["headers"]}
        problem = self._problem(scope, headers)
        if problem is not None:
            await problem(scope, receive, send)
            return
        await self.app(scope, self._limited(scope, receive), _with_headers(send))

    def _problem(self, scope: Scope, headers: dict[bytes, str]) -> ASGIApp | None:
        """Return the answer to a request that is refused; None where it is not."""
        host, origin = headers.get(b"host", ""), headers.get(b"origin")
        if self._settings.is_loopback and host.rsplit(":", 1)[0] not in LOOPBACK and host not in LOOPBACK:
            return problem_response(
                403, "Not allowed", f"host {host!r}: this service answers to its loopback names only"
            )
        if origin is not None and origin.partition("//")[2] != host:
            return problem_response(
                403, "Not allowed", f"origin {origin!r}: other sites may not call this service"
            )
        length, limit = headers.get(b"content-length", "0"), self._limit(scope)
        if not length.isdigit() or int(length) > limit:
            return problem_response(413, "Too large", f"{length} bytes; at most {limit} are accepted here")
        if not self._take_token((scope.get("client") or ("?",))[0]):
            return problem_response(
                429,
                "Too many calls",
                f"more than {self._settings.rate:g} calls a second; call less often",
                headers={"Retry-After": "1"},
            )
        return None

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
            present = {name for name, _ in message["headers"]}
            message["headers"] = [
                *message["headers"],
                *((name, value) for name, value in HEADERS.items() if name not in present),
            ]
        await send(message)

    return send_with_headers
