"""The robot's thread: reads the bus all the time, and drives and records the squares of a session."""

from __future__ import annotations

import contextlib
import logging
import tempfile
import threading
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from omnimate.driver.robot.recorder import Recorder
from omnimate.motion.drive import drive
from omnimate.motion.journal import Journal
from omnimate.motion.paths import squares
from omnimate.motion.runner import Runner
from omnimate.service.robot.connection import RobotConnection, connected
from omnimate.service.robot.frame_feed import FrameFeed
from omnimate.service.robot.observer import Observer
from omnimate.service.robot.reservation import Reservation
from omnimate.vehicle.errors import OmnimateError

if TYPE_CHECKING:
    from collections.abc import Callable
    from concurrent.futures import Future

    from omnimate.motion.program import Program
    from omnimate.service.robot.reservation import DriveOrder
    from omnimate.service.robot.session_reporter import SessionReporter
    from omnimate.service.umbmark.models import Direction
    from omnimate.vcan_sim.plant import Plant

T = TypeVar("T")
RENEW_PERIOD = 2.0  # [s] between two renewals of a session's lease
RETRY_PERIOD = 2.0  # [s] before the bus is opened again after a failure
COMPILATION_TIMEOUT = 90.0  # [s] at most, for which a new machine compiles what a robot calls
_log = logging.getLogger(__name__)


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
        self._connect = partial(
            connected, bus=bus, plant=plant, frame_feed=self.frame_feed, flight_recorder=flight_recorder
        )
        self._pace, self._reporter = pace, reporter
        self._executor = ThreadPoolExecutor(2, "session reports")  # while the robot's thread reads the bus
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
                with self._connect(self._reporter.vehicle()) as connection:
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
                self._drive_session(connection, reservation.order)

    def _drive_session(self, connection: RobotConnection, order: DriveOrder) -> None:
        """Drive the squares that the session still wants; what stops this interrupts the session.

        The robot is free before the session is seen to be over, so that a client may resume it at once. After
        an unexpected error it stands, and is still reserved: the caller ends the reservation.
        """
        driver = connection.driver
        problem: str | None = None
        try:
            self.reservation.require_wanted(order)
            driver.enable()
            connection.set_pace(self._pace)
            all_driven = self._drive_laps(connection, order)
        except OmnimateError as error:
            with contextlib.suppress(OmnimateError):  # no command to stop reaches a bus that is lost
                driver.stop()
            problem = str(error)
        finally:
            connection.set_pace(1.0)
            driver.drives.disable()
        self.reservation.end()
        if problem is not None:
            self._reporter.interrupted(order.session, problem)
        elif all_driven:
            self._while_reading(connection, self._reporter.finished, order.session)

    def _drive_laps(self, connection: RobotConnection, order: DriveOrder) -> bool:
        """Drive lap by lap; return whether all are driven, and not only one that a person has to measure."""
        while direction := self._while_reading(connection, self._reporter.next_direction, order.session):
            self.reservation.lap = direction
            self._drive_lap(connection, order, direction)
            if connection.fix is None:
                return False  # a person measures where the robot stands
        return True

    def _drive_lap(self, connection: RobotConnection, order: DriveOrder, direction: Direction) -> None:
        program = _program(connection, order, direction)
        vehicle = connection.driver.vehicle
        runner = self._while_reading(connection, Runner, program, vehicle)  # it may have to compile
        fix, locate = connection.fix, self.observer.locate
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place) / "lap"
            with Recorder(folder, vehicle, protocol=program.protocol, side=program.side) as recorder:
                journal = Journal(program, recorder)
                self.frame_feed.recorder = recorder
                try:
                    for moment in drive(connection.driver, runner, vehicle, journal, fix, locate):
                        self.observer.observe(moment.sample, connection.driver)
                        self.reservation.require_wanted(order)
                finally:
                    self.frame_feed.recorder = None
                    connection.driver.stop()
            self._while_reading(connection, self._reporter.lap_done, order.session, direction, folder)

    def _while_reading(self, connection: RobotConnection, call: Callable[..., T], *arguments: object) -> T:
        """Make a call in another thread and read the bus meanwhile, so that no sample is lost."""
        future: Future[T] = self._executor.submit(call, *arguments)
        while not future.done():
            self.observer.read(connection.driver)
        return future.result()


def _program(connection: RobotConnection, order: DriveOrder, direction: Direction) -> Program:
    """Return the program of one square, after the return to its start where a fix can be measured."""
    linkage = connection.driver.vehicle.linkage
    return squares(
        [direction],
        order.side,
        speed=order.speed,
        link_length=None if linkage is None else linkage.length,
        home_first=connection.fix is not None,
    )
