"""Events for everybody who listens: published from any thread, sent on by the server's loop."""

from __future__ import annotations

import asyncio
import contextlib
import json
import threading
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable

WAITING = 200  # events that a slow listener may be behind; older ones are dropped
GATHERED = 0.08  # [s] in which events are gathered, so that many cost no more than one


class Hub:
    """All listeners, and the last event of each kind, with which a new one begins."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._listeners: set[asyncio.Queue[bytes | None]] = set()
        self._last: dict[str, bytes] = {}
        self._pending: dict[tuple[str, str | None], bytes] = {}
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
        self._call(self._spread, None)

    def publish(self, kind: str, content: dict[str, Any]) -> None:
        """Send an event to everybody, soon; from any thread. Of one thing only the last word is sent."""
        event = f"event: {kind}\ndata: {json.dumps(content, allow_nan=False)}\n\n".encode()
        with self._lock:
            if kind in {"state", "nodes"}:
                self._last[kind] = event
            waiting = bool(self._pending)
            self._pending[kind, content.get("id")] = event
        if not waiting:
            self._call(self._later)

    def _call(self, what: Callable[..., None], *arguments: object) -> None:
        if self._loop is not None:
            with contextlib.suppress(RuntimeError):  # the loop has just been closed
                self._loop.call_soon_threadsafe(what, *arguments)

    def _later(self) -> None:
        asyncio.get_running_loop().call_later(GATHERED, self._flush)

    def _flush(self) -> None:
        with self._lock:
            events, self._pending = b"".join(self._pending.values()), {}
        self._spread(events)

    def _spread(self, event: bytes | None) -> None:
        for listener in self._listeners:
            if listener.full():
                listener.get_nowait()
            listener.put_nowait(event)

    async def listen(self) -> AsyncIterator[bytes]:
        """Yield events as server-sent events, for ever; without a robot there are some, too."""
        mine: asyncio.Queue[bytes | None] = asyncio.Queue(WAITING)
        for event in self._last.values():
            mine.put_nowait(event)
        self._listeners.add(mine)
        try:
            while (following := await mine.get()) is not None:
                yield following
        finally:
            self._listeners.discard(mine)
