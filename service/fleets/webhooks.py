"""Webhooks: messages about findings, signed, and sent again until they are accepted.

Headers, signature and pauses between attempts are those of the Standard Webhooks specification 1.0
(https://www.standardwebhooks.com), for which there are libraries in most languages.
"""

from __future__ import annotations

import base64
import hashlib
import hmac
import json
import secrets
import time
import urllib.error
import urllib.request
from dataclasses import dataclass
from http.client import HTTPException
from typing import TYPE_CHECKING, Any

from sqlalchemy import select, update

from omnimate.service.fleets.models import Webhook
from omnimate.service.store.tables import DeliveryRow, WebhookRow
from omnimate.service.threads import RepeatingThread

if TYPE_CHECKING:
    from collections.abc import Callable
    from email.message import Message as Headers
    from typing import IO

    from sqlalchemy.orm import Session

    from omnimate.service.store.database import Database


# [s] before each attempt, after the one before it failed: the schedule that the specification gives.
PAUSES = (0.0, 5.0, 300.0, 1800.0, 7200.0, 18000.0, 36000.0, 50400.0, 72000.0, 86400.0)
LEASE = 60.0  # [s] after which an attempt is made again whose service has died meanwhile
PREFIX = "whsec_"
SECRET_LENGTH = 32  # [bytes]; 24 to 64 are allowed
GONE = 410  # the status by which a receiver says that it wants no more


@dataclass(frozen=True, slots=True)
class Message:
    """A message that is to be sent now."""

    id: str
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


def claim_message(db: Session, now: float) -> Message | None:
    """Claim a message that is due; it is due again when its lease ends, unless it is settled before."""
    row = db.scalars(
        select(DeliveryRow)
        .where(DeliveryRow.state == "waiting", DeliveryRow.due <= now)
        .order_by(DeliveryRow.due)
        .limit(1)
        .with_for_update(skip_locked=True)
    ).first()
    if row is None:
        return None
    webhook = db.get(WebhookRow, row.webhook)
    assert webhook is not None, "messages of a removed webhook do not wait"
    row.attempts, row.due, row.changed = row.attempts + 1, now + LEASE, now
    return Message(row.id, row.attempts, webhook.url, webhook.secret, row.body)


def settle(db: Session, message: Message, status: int | None, answer: str, now: float) -> None:
    """Note how an attempt ended."""
    row = db.get(DeliveryRow, message.id, with_for_update=True)
    if row is None or row.state != "waiting" or row.attempts != message.attempt:
        return  # another service has taken it over, or the webhook was removed
    row.answer, row.changed = answer[:200], now
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


TIMEOUT = 15.0  # [s] for an answer; the specification says 15 to 30


class _NoRedirect(urllib.request.HTTPRedirectHandler):
    def redirect_request(
        self, req: urllib.request.Request, fp: IO[bytes], code: int, msg: str, headers: Headers, newurl: str
    ) -> None:
        """Follow no redirect: a message goes to the address that an operator gave, and to no other."""


_OPENER = urllib.request.build_opener(_NoRedirect, urllib.request.ProxyHandler({}))


def send_message(message: Message, now: float) -> tuple[int | None, str]:
    """Send a message once; return the HTTP status, None without an answer, and the answer in words."""
    request = urllib.request.Request(  # noqa: S310  # http and https only: `WebhookStart` accepts no other
        message.url, message.body.encode(), signed_headers(message, now), method="POST"
    )
    try:
        with _OPENER.open(request, timeout=TIMEOUT) as answer:
            return answer.status, f"{answer.status} {answer.reason}"
    except urllib.error.HTTPError as error:
        with error:
            return error.code, f"{error.code} {error.reason}"
    except (OSError, HTTPException, ValueError) as error:
        return None, f"no answer: {error}"


def deliver_next(
    database: Database,
    now: Callable[[], float] = time.time,
    send: Callable[[Message, float], tuple[int | None, str]] = send_message,
) -> bool:
    """Send the message that has been due longest; return whether there was one."""
    with database.writing() as db:
        message = claim_message(db, now())
    if message is not None:
        status, answer = send(message, now())
        with database.writing() as db:
            settle(db, message, status, answer, now())
    return message is not None


class Deliverer(RepeatingThread):
    """The thread of one service; several services may share a database.

    A message that it is sending when it is closed is sent again by the next service.
    """

    def __init__(self, database: Database) -> None:
        super().__init__("webhooks")
        self._database = database

    def work(self) -> bool:
        """Send a message that is due; return whether there was one."""
        return deliver_next(self._database)
