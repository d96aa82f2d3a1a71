"""The squares of one session, driven and recorded."""

from __future__ import annotations

import contextlib
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from omnimate.driver.robot.recorder import Recorder
from omnimate.motion.drive import drive
from omnimate.motion.journal import Journal
from omnimate.motion.paths import squares
from omnimate.motion.runner import Runner
from omnimate.vehicle.errors import OmnimateError

if TYPE_CHECKING:
    from collections.abc import Callable
    from concurrent.futures import Executor, Future

    from omnimate.motion.program import Program
    from omnimate.service.robot.connection import RobotConnection
    from omnimate.service.robot.frame_feed import FrameFeed
    from omnimate.service.robot.observer import Observer
    from omnimate.service.robot.reservation import DriveOrder, Reservation
    from omnimate.service.robot.session_reporter import SessionReporter
    from omnimate.service.umbmark.models import Direction

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class SessionDriver:
    """Drives what a session orders, in the robot's thread.

    Attributes:
        reservation: The session that the robot is reserved for, and whether it may go on.
        observer: Takes every sample.
        reporter: Stores the laps of the session.
        frame_feed: Gives the recorder every frame of the bus.
        executor: Runs the reporter's calls while the robot's thread reads the bus.
        pace: The pace of a simulated robot while it drives, as a multiple of real time.
    """

    reservation: Reservation
    observer: Observer
    reporter: SessionReporter
    frame_feed: FrameFeed
    executor: Executor
    pace: float

    def run(self, connection: RobotConnection, order: DriveOrder) -> None:
        """Drive the squares that the session still wants; what stops this interrupts the session.

        The robot is free before the session is seen to be over, so that a client may resume it at once. After
        an unexpected error it stands, and is still reserved: the caller ends the reservation.
        """
        driver = connection.driver
        problem: str | None = None
        try:
            self.reservation.require_wanted(order)
            driver.enable()
            connection.set_pace(self.pace)
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
            self.reporter.interrupted(order.session, problem)
        elif all_driven:
            self._while_reading(connection, self.reporter.finished, order.session)

    def _drive_laps(self, connection: RobotConnection, order: DriveOrder) -> bool:
        """Drive lap by lap; return whether all are driven, and not only one that a person has to measure."""
        while direction := self._while_reading(connection, self.reporter.next_direction, order.session):
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
            self._while_reading(connection, self.reporter.lap_done, order.session, direction, folder)

    def _while_reading(self, connection: RobotConnection, call: Callable[..., T], *arguments: object) -> T:
        """Make a call in another thread and read the bus meanwhile, so that no sample is lost."""
        future: Future[T] = self.executor.submit(call, *arguments)
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
