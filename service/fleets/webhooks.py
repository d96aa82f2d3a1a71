"""Webhooks: messages about findings, signed, and sent again until they are accepted.

Headers, signature and pauses between attempts are those of the Standard Webhooks specification 1.0
(https://www.standardwebhooks.com), for which there are libraries in most languages.
"""

from __future__ import annotations

import base64
import hashlib
import hmac
import io
import json
import logging
import secrets
import threading
import time
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from http.client import HTTPConnection, HTTPException, HTTPResponse, HTTPSConnection
from typing import TYPE_CHECKING, Any, cast
from urllib.parse import urlsplit, urlunsplit

from sqlalchemy import select, update

from omnimate.service.fleets.models import Webhook
from omnimate.service.store.tables import DeliveryRow, WebhookRow
from omnimate.service.threads import CLOSING_TIME, RepeatingThread

if TYPE_CHECKING:
    import socket
    from collections.abc import Collection

    from sqlalchemy.orm import Session

    from omnimate.service.store.database import Database


# [s] before each attempt, after the one before it failed: the schedule that the specification gives.
PAUSES = (0.0, 5.0, 300.0, 1800.0, 7200.0, 18000.0, 36000.0, 50400.0, 72000.0, 86400.0)
LEASE = 60.0  # [s] after which an attempt is made again whose service has died meanwhile
PREFIX = "whsec_"
SECRET_LENGTH = 32  # [bytes]; 24 to 64 are allowed
_CONNECTIONS = {"http": HTTPConnection, "https": HTTPSConnection}
_log = logging.getLogger(__name__)
GONE = 410  # the status by which a receiver says that it wants no more


@dataclass(frozen=True, slots=True)
class Message:
    """A message that is to be sent now."""

    id: str
    webhook: str
    attempt: int
    url: str
    secret: str
    body: str


def add_webhook(db: Session, fleet: str, url: str) -> WebhookRow:
    """Add a webhook with a new secret."""
    secret = PREFIX + base64.b64encode(secrets.token_bytes(SECRET_LENGTH)).decode()
    row = WebhookRow(fleet=fleet, url=url, secret=secret)
    db.add(row)
    db.flush()
    return row


def remove_webhook(db: Session, row: WebhookRow) -> None:
    """Remove a webhook, and give up its messages."""
    waiting = (DeliveryRow.webhook == row.id) & (DeliveryRow.state == "waiting")
    db.execute(update(DeliveryRow).where(waiting).values(state="given up", answer="the webhook was removed"))
    db.delete(row)


def webhook_view(row: WebhookRow, *, whole: bool = False) -> Webhook:
    """Return a webhook as clients see it, with its secret when it was just made."""
    return Webhook.of(row, secret=row.secret if whole else None)


def queue_message(db: Session, fleet: str, content: dict[str, Any]) -> None:
    """Queue a message to all webhooks of a fleet."""
    for webhook in db.scalars(select(WebhookRow.id).where(WebhookRow.fleet == fleet)):
        db.add(DeliveryRow(webhook=webhook, body=json.dumps(content)))


def claim_message(db: Session, now: float, busy: Collection[str] = ()) -> Message | None:
    """Claim a message that is due at a time [s since 1970], but none to a busy webhook.

    It is due again when its lease ends, unless it is settled before.
    """
    row = db.scalars(
        select(DeliveryRow)
        .where(DeliveryRow.state == "waiting", DeliveryRow.due <= now, DeliveryRow.webhook.not_in(busy))
        .order_by(DeliveryRow.due)
        .limit(1)
        .with_for_update(skip_locked=True)
    ).first()
    if row is None:
        return None
    webhook = db.get(WebhookRow, row.webhook)
    assert webhook is not None, "messages of a removed webhook do not wait"
    row.attempts, row.due, row.changed = row.attempts + 1, now + LEASE, now
    return Message(row.id, webhook.id, row.attempts, webhook.url, webhook.secret, row.body)


def settle(db: Session, message: Message, status: int | None, answer: str, now: float) -> None:
    """Note how an attempt ended."""
    row = db.get(DeliveryRow, message.id, with_for_update=True)
    if row is None or row.state != "waiting" or row.attempts != message.attempt:
        return  # another service has taken it over, or the webhook was removed
    row.answer, row.changed = answer.replace("\0", " ")[:200], now  # PostgreSQL's texts hold no NUL
    if status is not None and 200 <= status < 300:
        row.state = "accepted"
    elif status == GONE or row.attempts >= len(PAUSES):
        row.state = "given up"
    else:
        row.due = now + PAUSES[row.attempts]


def signed_headers(message: Message, now: float) -> dict[str, str]:
    """Return the headers of an attempt: the message's id, the time, the signature of these and the body."""
    stamp = str(int(now))
    signed = f"{message.id}.{stamp}.{message.body}".encode()
    key = base64.b64decode(message.secret.removeprefix(PREFIX))
    signature = base64.b64encode(hmac.new(key, signed, hashlib.sha256).digest()).decode()
    return {
        "Content-Type": "application/json",
        "webhook-id": message.id,
        "webhook-timestamp": stamp,
        "webhook-signature": f"v1,{signature}",
    }


ATTEMPT_TIME = 15.0  # [s] for an attempt; the specification says 15 to 30
MAX_ATTEMPTS = 16  # at a time, each to another receiver


class _TimedAnswer(io.RawIOBase):
    """What a receiver answers until a deadline; `HTTPResponse` reads it in the place of a socket."""

    def __init__(self, connection: socket.socket, end: float, clock: Callable[[], float]) -> None:
        super().__init__()
        self._connection, self._end, self._clock = connection, end, clock

    def makefile(self, _mode: str) -> io.BufferedReader:
        return io.BufferedReader(self)

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: Any) -> int:  # noqa: ANN401 -- any writable buffer; it has a name from 3.12 on
        left = self._end - self._clock()  # of the attempt: a socket's timeout is that of one operation
        if left <= 0.0:
            raise TimeoutError(f"not within {ATTEMPT_TIME:g} s")
        self._connection.settimeout(left)
        return self._connection.recv_into(buffer)


def send_message(
    message: Message, now: float, clock: Callable[[], float] = time.monotonic
) -> tuple[int | None, str]:
    """Send a message once; return the HTTP status, None without an answer, and the answer in words.

    A redirect is not followed, and no proxy is used: a message goes to the address that an operator gave.
    It is signed for the time `now` [s since 1970]; `clock` measures the attempt [s].
    """
    end = clock() + ATTEMPT_TIME
    try:
        url = urlsplit(message.url)
        with closing(_CONNECTIONS[url.scheme](url.netloc, timeout=ATTEMPT_TIME)) as connection:
            path = urlunsplit(("", "", url.path or "/", url.query, ""))
            connection.request("POST", path, message.body.encode(), signed_headers(message, now))
            stream = cast("socket.socket", _TimedAnswer(connection.sock, end, clock))
            with HTTPResponse(stream, method="POST") as answer:
                answer.begin()
                return answer.status, f"{answer.status} {answer.reason}"
    except (OSError, HTTPException, ValueError) as error:
        return None, f"no answer: {error}"


Send = Callable[[Message, float], tuple[int | None, str]]


def deliver(
    database: Database, message: Message, now: Callable[[], float] = time.time, send: Send = send_message
) -> None:
    """Send a message that was claimed, and note the answer."""
    status, answer = send(message, now())
    with database.writing() as db:
        settle(db, message, status, answer, now())


class Deliverer(RepeatingThread):
    """The thread of one service, and those of its attempts; several services may share a database.

    Receivers do not wait for each other: there is one attempt at a time to each of them. A message that is
    being sent when the service ends is sent again by the next one.
    """

    def __init__(self, database: Database, send: Send = send_message) -> None:
        super().__init__("webhooks")
        self._database, self._send = database, send
        self._attempts: dict[str, threading.Thread] = {}  # by the webhook

    def work(self) -> bool:
        """Begin to send a message that is due; return whether there was one."""
        if len(self._attempts) >= MAX_ATTEMPTS:
            return False
        with self._database.writing() as db:
            message = claim_message(db, time.time(), list(self._attempts))
        if message is None:
            return False
        attempt = threading.Thread(target=self._deliver, args=(message,), name="webhook", daemon=True)
        self._attempts[message.webhook] = attempt
        attempt.start()
        return True

    def _deliver(self, message: Message) -> None:
        try:
            deliver(self._database, message, send=self._send)
        except Exception:  # noqa: BLE001  # the database may be away: the message is due when its lease ends
            _log.exception("the answer to message %s was not noted; it is sent again", message.id)
        finally:
            del self._attempts[message.webhook]
            self.wake()

    def close(self) -> None:
        """End the threads; what is not answered soon is left to the next service."""
        super().close()
        end = time.monotonic() + CLOSING_TIME
        for attempt in list(self._attempts.values()):
            attempt.join(max(0.0, end - time.monotonic()))
