"""The robot's thread: reads the bus all the time, and drives when a session is reserved and begun."""

from __future__ import annotations

import logging
import threading
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING

from omnimate.service.robot.connection import RobotConnection, connected
from omnimate.service.robot.frame_feed import FrameFeed
from omnimate.service.robot.observer import Observer
from omnimate.service.robot.reservation import Reservation
from omnimate.service.robot.session_drive import SessionDriver
from omnimate.vehicle.errors import OmnimateError

if TYPE_CHECKING:
    from pathlib import Path

    from omnimate.service.robot.session_reporter import SessionReporter
    from omnimate.vcan_sim.plant import Plant

RENEW_PERIOD = 2.0  # [s] between two renewals of a session's lease
RETRY_PERIOD = 2.0  # [s] before the bus is opened again after a failure
_log = logging.getLogger(__name__)

COMPILATION_TIMEOUT = 90.0  # [s] at most, for which a new machine compiles what a robot calls


class RobotThread:
    """The robot on the bus; its methods may be called from any thread."""

    def __init__(
        self,
        bus: str | None,
        plant: Plant | None,
        pace: float,
        reporter: SessionReporter,
        flight_recorder: Path | None = None,
    ) -> None:
        self.reservation = Reservation()
        self.observer = Observer("simulated" if bus is None else "bus", self.reservation)
        self.frame_feed = FrameFeed()
        self._bus, self._plant, self._reporter = bus, plant, reporter
        self._flight_recorder = flight_recorder
        self._executor = ThreadPoolExecutor(2, "session reports")
        self._session_driver = SessionDriver(
            self.reservation, self.observer, reporter, self.frame_feed, self._executor, pace
        )
        self._ending, self._reloading = threading.Event(), threading.Event()
        self._thread = threading.Thread(target=self._run, name="robot", daemon=True)
        self._lease_thread = threading.Thread(target=self._renew_leases, name="lease", daemon=True)

    def start(self) -> None:
        """Start the threads."""
        self._thread.start()
        self._lease_thread.start()

    def close(self) -> None:
        """Stop the robot and end the threads."""
        self.reservation.stop("the service was stopped")
        self._ending.set()
        if self._thread.is_alive():
            self._thread.join(COMPILATION_TIMEOUT)
        self._executor.shutdown()

    def reload(self) -> None:
        """Take the vehicle's newest parameters as soon as the robot does not drive."""
        self._reloading.set()

    def _renew_leases(self) -> None:
        while not self._ending.wait(RENEW_PERIOD):
            self.renew_lease()

    def renew_lease(self) -> None:
        """Renew the lease of the session that is driven, even while the robot's thread is busy.

        The robot stops where the session is not this service's any more.
        """
        order = self.reservation.order
        if order is not None:
            try:
                if self._reporter.renew(order.session):
                    self.reservation.note_lease()
                else:
                    self.reservation.stop("the session is over, or driven by another service", order.session)
            except Exception:  # noqa: BLE001  # the database may be away; the robot stops when the lease ends
                _log.exception("the lease of session %s was not renewed", order.session)

    def _run(self) -> None:
        while not self._ending.is_set():
            try:
                self._reloading.clear()
                with connected(
                    self._reporter.vehicle(),
                    self._bus,
                    self._plant,
                    self.frame_feed,
                    self._flight_recorder,
                ) as connection:
                    self._read_and_drive(connection)
            except OmnimateError as error:
                self._lose_robot(str(error))
            except Exception as error:  # noqa: BLE001  # without this thread, no client could stop the robot
                _log.exception("the robot's thread failed")
                self._lose_robot(f"an error in the service itself: {error}")

    def _lose_robot(self, problem: str) -> None:
        """Report that there is no robot, and wait before the next attempt."""
        self.reservation.problem = problem
        session = self.reservation.end()
        if session is not None:
            try:
                self._reporter.interrupted(session, problem)
            except Exception:  # noqa: BLE001  # the database may be away; the session's lease ends then
                _log.exception("it was not noted that session %s is interrupted", session)
        self.observer.note_problem()
        self._ending.wait(RETRY_PERIOD)

    def _read_and_drive(self, connection: RobotConnection) -> None:
        driver, reservation = connection.driver, self.reservation
        self.observer.begin(driver.vehicle)
        reservation.problem = None
        while not (self._ending.is_set() or self._reloading.is_set()):
            self.observer.read(driver)
            if reservation.order is not None:
                self._session_driver.run(connection, reservation.order)
