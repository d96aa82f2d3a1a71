"""The events that clients read as server-sent events: published by any thread, sent by the server's loop."""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
import threading
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import AsyncGenerator, Callable

_log = logging.getLogger(__name__)
QUEUED_EVENTS = 200  # that a slow client may be behind; older ones are dropped
GATHERING_TIME = 0.08  # [s] in which events are gathered, so that many of them are sent at once
KEPT_KINDS = {"state", "nodes"}  # of which a new client receives the last event first


class EventStream:
    """All clients of the stream, and the last event of each kind that a new client receives first.

    Within the gathering time, an event replaces an earlier one of the same kind about the same object.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._clients: set[asyncio.Queue[bytes | None]] = set()
        self._last: dict[str, bytes] = {}
        self._pending: dict[tuple[str, str | None], Callable[[], bytes]] = {}
        self._sending: asyncio.Task[None] | None = None
        self.is_closed = False

    @property
    def listeners(self) -> int:
        """The number of clients."""
        return len(self._clients)

    @property
    def has_readers(self) -> bool:
        """Whether a client reads what is sent; one whose network is gone stays until TCP gives it up."""
        return not all(client.full() for client in tuple(self._clients))

    def open(self, loop: asyncio.AbstractEventLoop) -> None:
        """Begin to send, on the server's loop."""
        self._loop = loop

    def close(self) -> None:
        """End the streams of all clients."""
        self.is_closed = True
        self._call_in_loop(self._send, None)

    def publish(self, kind: str, content: dict[str, Any]) -> None:
        """Send an event to all clients after the gathering time; from any thread."""
        event = _encoded(kind, content)
        if kind in KEPT_KINDS:
            self._last[kind] = event
        self._add(kind, content.get("id"), lambda: event)

    def announce(self, kind: str, identity: str, read: Callable[[str], dict[str, Any]]) -> None:
        """Send the state of an object after the gathering time, when `read` is called once to return it."""
        self._add(kind, identity, lambda: _encoded(kind, read(identity)))

    def _add(self, kind: str, identity: str | None, event: Callable[[], bytes]) -> None:
        with self._lock:
            gathering = bool(self._pending)
            self._pending[kind, identity] = event
        if not gathering:
            self._call_in_loop(self._start_sending)

    def _call_in_loop(self, function: Callable[..., None], *arguments: object) -> None:
        if self._loop is not None:
            with contextlib.suppress(RuntimeError):  # the loop has just been closed
                self._loop.call_soon_threadsafe(function, *arguments)

    def _start_sending(self) -> None:
        self._sending = asyncio.create_task(self._send_gathered(self._sending))

    async def _send_gathered(self, former: asyncio.Task[None] | None) -> None:
        await asyncio.sleep(GATHERING_TIME)
        with self._lock:
            pending, self._pending = self._pending, {}
        events = await asyncio.to_thread(_joined, pending)
        if former is not None:
            await former  # so that older events are not sent after newer ones
        self._send(events)

    def _send(self, event: bytes | None) -> None:
        for client in self._clients:
            if client.full():
                client.get_nowait()
            client.put_nowait(event)

    async def listen(self) -> AsyncGenerator[bytes]:
        """Yield events as server-sent events until the stream is closed."""
        events: asyncio.Queue[bytes | None] = asyncio.Queue(QUEUED_EVENTS)
        for event in self._last.values():
            events.put_nowait(event)
        self._clients.add(events)
        try:
            while (next_event := await events.get()) is not None:
                yield next_event
        finally:
            self._clients.discard(events)


def _encoded(kind: str, content: dict[str, Any]) -> bytes:
    return f"event: {kind}\ndata: {json.dumps(content, allow_nan=False)}\n\n".encode()


def _joined(pending: dict[tuple[str, str | None], Callable[[], bytes]]) -> bytes:
    """Return all events as one text; an event that cannot be made is left out."""
    events = []
    for (kind, identity), event in pending.items():
        try:
            events.append(event())
        except Exception:  # noqa: BLE001  # the database may be away, for instance
            _log.exception("the event %s of %s was not sent", kind, identity)
    return b"".join(events)
