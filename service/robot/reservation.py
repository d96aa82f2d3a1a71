"""The session that the robot is reserved for, and whether it may go on."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

from omnimate.service.errors import StateError, UnavailableError
from omnimate.service.umbmark.sessions import LEASE
from omnimate.vehicle.errors import OmnimateError

if TYPE_CHECKING:
    from omnimate.service.umbmark.models import Direction


class StoppedError(OmnimateError):
    """The robot was stopped, or no client asks for the session any more."""


@dataclass(frozen=True, slots=True)
class DriveOrder:
    """The squares that the robot is to drive for a session."""

    session: str  # its id
    side: float  # of the square [m]
    speed: float  # of the wheels [m/s]
    lifeline: float | None  # [s] without any client after which the robot stops; None never stops it


class Reservation:
    """Which session the robot drives for; its methods may be called from any thread."""

    def __init__(self) -> None:
        self.problem: str | None = "starting"  # why the robot cannot drive; None where it can
        self.session: str | None = None  # id of the session that the robot is reserved for
        self.order: DriveOrder | None = None  # what the robot drives; None before the session has begun
        self.lap: Direction | None = None  # that is being driven; None between laps
        self.stop_reason: str | None = None  # why the session has to stop; it stays until the session ends
        self._lock = threading.Lock()
        self._last_contact = self._last_lease = 0.0

    def reserve(self, session: str) -> None:
        """Reserve the robot for a session that is going to be driven; nothing moves yet.

        Raises:
            UnavailableError: the robot cannot drive.
            StateError: the robot is reserved for another session.
        """
        with self._lock:
            if self.problem is not None:
                raise UnavailableError(f"the robot is not available: {self.problem}")
            if self.session is not None:
                raise StateError(
                    f"the robot drives for session {self.session}; abort it, or wait for its end"
                )
            self.session = session

    def release(self, session: str) -> None:
        """Cancel the reservation of a session that has not begun."""
        with self._lock:
            if self.session == session and self.order is None:
                self.session = self.stop_reason = None

    def begin(self, order: DriveOrder) -> bool:
        """Have the robot drive, if it is still reserved for the order's session; return whether it is."""
        with self._lock:
            self._last_contact = self._last_lease = time.monotonic()
            if self.session == order.session:
                self.order = order
            return self.order is order

    def stop(self, reason: str, session: str | None = None) -> None:
        """Stop the robot at the next sample; a session that has not begun is stopped before it moves.

        Without a session nothing moves, and a later session is not stopped. With the id of a session, only
        this one is stopped.
        """
        with self._lock:
            if self.session is not None and session in (None, self.session):
                self.stop_reason = reason

    def end(self) -> str | None:
        """End the reservation; return the id of the session that had it."""
        with self._lock:
            session = self.session
            self.session = self.order = self.lap = self.stop_reason = None
        return session

    def note_client(self, session: str | None = None) -> None:
        """Note that a client asked for a session just now; None stands for the one that is driven."""
        if session is None or session == self.session:
            self._last_contact = time.monotonic()

    def note_lease(self) -> None:
        """Note that the lease of the session that is driven was renewed just now."""
        self._last_lease = time.monotonic()

    def require_wanted(self, order: DriveOrder) -> None:
        """Raise StoppedError where the robot was stopped, no client asked in time, or the lease has ended."""
        if self.stop_reason is not None:
            raise StoppedError(self.stop_reason)
        now = time.monotonic()
        if now - self._last_lease > LEASE:
            raise StoppedError(
                f"the database took no note of the session for {LEASE:g} s; the robot was stopped"
            )
        silence = now - self._last_contact
        if order.lifeline is not None and silence > order.lifeline:
            raise StoppedError(
                f"no client asked for the session for {order.lifeline:g} s; the robot was stopped"
            )
