"""Driving for a session: the robot is reserved in the session's transaction, and begins after its commit."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.service.errors import InvalidValueError
from omnimate.service.robot.reservation import DriveOrder
from omnimate.service.umbmark.sessions import take_lease

if TYPE_CHECKING:
    from collections.abc import Callable

    from fastapi.responses import Response

    from omnimate.service.components import Components
    from omnimate.service.store.tables import SessionRow


class SessionDrives:
    """The drives that a call prepares."""

    def __init__(self, components: Components) -> None:
        self._components = components
        self._orders: list[DriveOrder] = []

    def prepare(self, row: SessionRow) -> None:
        """Reserve the robot on the bus for a session.

        Raises:
            InvalidValueError: the session is of another vehicle.
            UnavailableError: the robot cannot drive now.
            StateError: the robot drives for another session.
        """
        components = self._components
        if row.vehicle != components.vehicle:
            raise InvalidValueError(
                "vehicle", f"{row.vehicle!r} is not on the bus; only {components.vehicle!r} can drive"
            )
        components.robot.reservation.reserve(row.id)
        take_lease(row, components.settings.instance)
        self._orders.append(DriveOrder(row.id, row.side, row.speed, row.lifeline))

    def begin_after(self, commit: Callable[[], Response]) -> Response:
        """Commit the session, then let the robot drive; it does not drive where the commit fails."""
        reservation = self._components.robot.reservation
        try:
            response = commit()
        except BaseException:
            for order in self._orders:
                reservation.release(order.session)
            raise
        for order in self._orders:
            reservation.begin(order)
            self._components.reporter.announce(order.session)
        return response
