"""What reaches the application: bodies of a bounded size, from this page, at a bounded rate."""

from __future__ import annotations

import time
from collections import OrderedDict
from typing import TYPE_CHECKING

from fastapi import HTTPException

from service.problems import answer

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

    from service.settings import Settings

SECONDS = 3.0  # of calls that may come at once
REMEMBERED = 10_000  # callers
UPLOADS = "/v1/recordings"
LOOPBACK = {"localhost", "127.0.0.1", "[::1]", "::1"}
HEADERS = {
    b"x-content-type-options": b"nosniff",
    b"referrer-policy": b"no-referrer",
    b"content-security-policy": b"default-src 'self'; img-src 'self' data: blob:; frame-src 'self' blob:; "
    b"frame-ancestors 'self'; base-uri 'none'; form-action 'self'",
}


class Limits:
    """An ASGI application in front of another one."""

    def __init__(self, app: ASGIApp, settings: Settings) -> None:
        self.app = app
        self._settings = settings
        self._buckets: OrderedDict[str, tuple[float, float]] = OrderedDict()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a call, or refuse it before anybody looks at it."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        headers = {name: value.decode("latin-1") for name, value in scope["headers"]}
        refused = self._refusal(scope, headers)
        if refused is not None:
            await answer(*refused, headers={"Retry-After": "1"} if refused[0] == 429 else None)(
                scope, receive, send
            )
            return
        await self.app(scope, self._counted(scope, receive), _with_headers(send))

    def _refusal(self, scope: Scope, headers: dict[bytes, str]) -> tuple[int, str, str] | None:
        host = headers.get(b"host", "")
        if self._settings.is_loopback and host.rsplit(":", 1)[0] not in LOOPBACK and host not in LOOPBACK:
            return (
                403,
                "Not allowed",
                f"host {host!r}: this service answers to its loopback names only",
            )
        origin = headers.get(b"origin")
        if origin is not None and origin.partition("//")[2] != host:
            return 403, "Not allowed", f"origin {origin!r}: other sites may not call this service"
        length = headers.get(b"content-length", "0")
        limit = self._limit(scope)
        if not length.isdigit() or int(length) > limit:
            return 413, "Too large", f"{length} bytes; at most {limit} are taken here"
        if not self._may((scope.get("client") or ("?",))[0]):
            return (
                429,
                "Too many calls",
                f"more than {self._settings.rate:g} calls a second; call less often",
            )
        return None

    def _limit(self, scope: Scope) -> int:
        upload = scope["method"] == "POST" and scope["path"].rstrip("/") == UPLOADS
        return self._settings.upload if upload else self._settings.body

    def _may(self, caller: str) -> bool:
        """Take a token from the caller's bucket, if there is one."""
        now, rate = time.monotonic(), self._settings.rate
        tokens, then = self._buckets.pop(caller, (rate * SECONDS, now))
        tokens = min(rate * SECONDS, tokens + rate * (now - then))
        self._buckets[caller] = (tokens - 1.0 if tokens >= 1.0 else tokens, now)
        if len(self._buckets) > REMEMBERED:
            self._buckets.popitem(last=False)
        return tokens >= 1.0

    def _counted(self, scope: Scope, receive: Receive) -> Receive:
        """Return a receiver that ends when more comes than the limit, whatever was announced."""
        limit, taken = self._limit(scope), 0

        async def counted() -> Message:
            nonlocal taken
            message = await receive()
            taken += len(message.get("body", b""))
            if taken > limit:
                raise HTTPException(413, f"more than {limit} bytes; that is the most that is taken here")
            return message

        return counted


def _with_headers(send: Send) -> Send:
    async def sent(message: Message) -> None:
        if message["type"] == "http.response.start":
            own = {name for name, _ in message["headers"]}
            message["headers"] = [
                *message["headers"], *((name, value) for name, value in HEADERS.items() if name not in own)
            ]  # fmt: skip
        await send(message)

    return sent
