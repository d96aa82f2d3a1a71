"""The components of the application, which are started and stopped together."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from sqlalchemy.exc import IntegrityError

from omnimate.service.access import Callers
from omnimate.service.event_stream import EventStream
from omnimate.service.jobs.worker import Worker
from omnimate.service.robot.connection import simulated_plant
from omnimate.service.robot.robot_thread import RobotThread
from omnimate.service.robot.session_reporter import SessionReporter
from omnimate.service.store import vehicles
from omnimate.service.store.database import Database
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vehicle.file import format_vehicle, load_vehicle

if TYPE_CHECKING:
    import asyncio

    from omnimate.service.settings import Settings
    from omnimate.vehicle.parameters import VehicleParameters


@dataclass(frozen=True, slots=True)
class Components:
    """The components of the application.

    Attributes:
        settings: The settings by which the components were made.
        database: The database.
        events: The event stream.
        vehicle: The name of the robot on the bus.
        reporter: Writes to the database what the robot's thread reports.
        robot: The robot on the bus.
        worker: Works on the queued diagnoses.
        callers: The callers of the last second.
    """

    settings: Settings
    database: Database
    events: EventStream
    vehicle: str
    reporter: SessionReporter
    robot: RobotThread
    worker: Worker
    callers: Callers

    def start(self, loop: asyncio.AbstractEventLoop) -> None:
        """Start the threads, and send events on the server's loop."""
        self.events.open(loop)
        self.robot.start()
        self.worker.start()

    def close(self) -> None:
        """Stop the robot, end the threads, and close the database."""
        self.events.close()
        self.robot.close()
        self.worker.close()
        self.database.close()


def make_components(settings: Settings) -> Components:
    """Return the components, none of them started.

    Raises:
        DatabaseError: the database cannot be used.
        VehicleFileError: the vehicle file cannot be read.
    """
    vehicle = reference_vehicle() if settings.vehicle is None else load_vehicle(settings.vehicle)
    database, events = Database(settings.database), EventStream()
    try:
        first = _first_version(database, vehicle)
    except IntegrityError:  # another service that starts at the same time was faster
        first = _first_version(database, vehicle)
    plant = simulated_plant(first) if settings.bus is None else None
    reporter = SessionReporter(database, events, vehicle.name, settings.instance)
    robot = RobotThread(settings.bus, plant, settings.pace, events, reporter)
    worker = Worker(database, events, reporter, settings.instance, settings.unpacked)
    callers = Callers(keyless_allowed=settings.is_loopback)
    return Components(settings, database, events, vehicle.name, reporter, robot, worker, callers)


def _first_version(database: Database, vehicle: VehicleParameters) -> VehicleParameters:
    """Return the robot's first version, after adding a version where its file is new or has changed.

    A file that equals a former version adds none: the calibrations since then started from it.
    """
    text = format_vehicle(vehicle)
    with database.writing() as db:
        if all(row.name != vehicle.name for row in vehicles.newest_of_all(db)):
            vehicles.create(db, vehicle, "file")
        elif all(row.toml != text for row in vehicles.versions(db, vehicle.name)):
            vehicles.add_version(db, vehicle, "file", None)
        return vehicles.parameters_of(vehicles.version(db, vehicle.name, 1))
