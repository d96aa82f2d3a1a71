"""Events for everybody who listens: published from any thread, sent on by the server's loop."""

from __future__ import annotations

import asyncio
import contextlib
import json
import threading
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

WAITING = 200  # events that a slow listener may be behind; older ones are dropped
KEEP = 10.0  # [s] of silence after which a comment is sent, so that a lost listener is noticed


class Hub:
    """All listeners, and the last event of each kind, with which a new one begins."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._listeners: set[asyncio.Queue[bytes | None]] = set()
        self._last: dict[str, bytes] = {}
        self._closed = False

    @property
    def listeners(self) -> int:
        """How many listen."""
        return len(self._listeners)

    @property
    def is_closed(self) -> bool:
        """Whether the service ends."""
        return self._closed

    def open(self, loop: asyncio.AbstractEventLoop) -> None:
        """Begin to send, on the server's loop."""
        self._loop = loop

    def close(self) -> None:
        """End all streams."""
        self._closed = True
        self._send(None)

    def publish(self, kind: str, content: dict[str, Any]) -> None:
        """Send an event to everybody; from any thread."""
        event = f"event: {kind}\ndata: {json.dumps(content, allow_nan=False)}\n\n".encode()
        if kind in {"state", "nodes"}:
            self._last[kind] = event
        self._send(event)

    def _send(self, event: bytes | None) -> None:
        if self._loop is not None and self._listeners:
            with contextlib.suppress(RuntimeError):  # the loop has just been closed
                self._loop.call_soon_threadsafe(self._spread, event)

    def _spread(self, event: bytes | None) -> None:
        for listener in self._listeners:
            if listener.full():
                listener.get_nowait()
            listener.put_nowait(event)

    async def listen(self) -> AsyncIterator[bytes]:
        """Yield events as server-sent events, for ever."""
        mine: asyncio.Queue[bytes | None] = asyncio.Queue(WAITING)
        for event in self._last.values():
            mine.put_nowait(event)
        self._listeners.add(mine)
        try:
            while not self._closed:
                following = await _next(mine)
                if following is None:
                    break
                yield following
        finally:
            self._listeners.discard(mine)


async def _next(queue: asyncio.Queue[bytes | None]) -> bytes | None:
    """Return the next event, or a comment when there is none for a while."""
    try:
        async with asyncio.timeout(KEEP):
            return await queue.get()
    except TimeoutError:
        return b": still here\n\n"
