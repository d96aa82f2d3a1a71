"""Events for everybody who listens: published from any thread, sent on by the server's loop."""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
import threading
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable

_log = logging.getLogger(__name__)
WAITING = 200  # events that a slow listener may be behind; older ones are dropped
GATHERED = 0.08  # [s] in which events are gathered, so that many cost no more than one


class Hub:
    """All listeners, and the last event of each kind, with which a new one begins."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._listeners: set[asyncio.Queue[bytes | None]] = set()
        self._last: dict[str, bytes] = {}
        self._pending: dict[tuple[str, str | None], Callable[[], bytes]] = {}
        self._sending: asyncio.Task[None] | None = None
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
        event = _event(kind, content)
        if kind in {"state", "nodes"}:
            self._last[kind] = event
        self._put(kind, content.get("id"), lambda: event)

    def announce(self, kind: str, identity: str, look: Callable[[str], dict[str, Any]]) -> None:
        """Send what a thing looks like, soon; it is looked at once, however often it changes meanwhile."""
        self._put(kind, identity, lambda: _event(kind, look(identity)))

    def _put(self, kind: str, identity: str | None, event: Callable[[], bytes]) -> None:
        with self._lock:
            waiting = bool(self._pending)
            self._pending[kind, identity] = event
        if not waiting:
            self._call(self._later)

    def _call(self, what: Callable[..., None], *arguments: object) -> None:
        if self._loop is not None:
            with contextlib.suppress(RuntimeError):  # the loop has just been closed
                self._loop.call_soon_threadsafe(what, *arguments)

    def _later(self) -> None:
        self._sending = asyncio.create_task(self._flush(self._sending))

    async def _flush(self, before: asyncio.Task[None] | None) -> None:
        await asyncio.sleep(GATHERED)
        with self._lock:
            pending, self._pending = self._pending, {}
        events = await asyncio.to_thread(_joined, pending)
        if before is not None:
            await before  # so that older events are not sent after newer ones
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


def _event(kind: str, content: dict[str, Any]) -> bytes:
    return f"event: {kind}\ndata: {json.dumps(content, allow_nan=False)}\n\n".encode()


def _joined(pending: dict[tuple[str, str | None], Callable[[], bytes]]) -> bytes:
    """Return all events as one; one that cannot be made does not keep the others back."""
    events = []
    for (kind, identity), event in pending.items():
        try:
            events.append(event())
        except Exception:  # noqa: BLE001  # a database that is away, for instance
            _log.exception("the event %s of %s was not sent", kind, identity)
    return b"".join(events)
