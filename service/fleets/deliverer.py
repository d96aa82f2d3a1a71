"""The thread that sends messages to webhooks."""

from __future__ import annotations

import logging
import threading
import time
import urllib.error
import urllib.request
from http.client import HTTPException
from typing import TYPE_CHECKING

from sqlalchemy.exc import SQLAlchemyError

from omnimate.service.fleets.webhooks import Message, claim_message, settle, signed_headers

if TYPE_CHECKING:
    from collections.abc import Callable
    from email.message import Message as Headers
    from typing import IO

    from omnimate.service.store.database import Database

LOOK_PERIOD = 1.0  # [s] between two looks for a message that is due
TIMEOUT = 15.0  # [s] for an answer; the specification says 15 to 30
_log = logging.getLogger(__name__)


class _NoRedirect(urllib.request.HTTPRedirectHandler):
    def redirect_request(
        self, req: urllib.request.Request, fp: IO[bytes], code: int, msg: str, headers: Headers, newurl: str
    ) -> None:
        """Follow no redirect: a message goes to the address that an operator gave, and nowhere else."""


_OPENER = urllib.request.build_opener(_NoRedirect, urllib.request.ProxyHandler({}))


def send_message(message: Message, now: float) -> tuple[int | None, str]:
    """Send a message once; return the HTTP status, None without an answer, and the answer in words."""
    request = urllib.request.Request(  # noqa: S310  # http and https only: `WebhookStart` sees to it
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


def deliver_due(
    database: Database,
    now: Callable[[], float] = time.time,
    send: Callable[[Message, float], tuple[int | None, str]] = send_message,
) -> int:
    """Send every message that is due once; return how many."""
    count = 0
    while True:
        with database.writing() as db:
            message = claim_message(db, now())
        if message is None:
            return count
        status, answer = send(message, now())
        with database.writing() as db:
            settle(db, message, status, answer, now())
        count += 1


class Deliverer:
    """The thread of one service; several services may share a database."""

    def __init__(self, database: Database) -> None:
        self._database = database
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._run, name="webhooks", daemon=True)

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def close(self) -> None:
        """End the thread; a message that it is sending is sent again by the next service."""
        self._ending.set()
        if self._thread.is_alive():
            self._thread.join(2.0)

    def _run(self) -> None:
        while not self._ending.wait(LOOK_PERIOD):
            try:
                deliver_due(self._database)
            except SQLAlchemyError:
                _log.exception("the database did not answer; it is tried again")
