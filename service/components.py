"""The components of the application, which are started and stopped together."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from omnimate.service.access import Callers
from omnimate.service.errors import StateError
from omnimate.service.event_stream import EventStream
from omnimate.service.fleets.batches import BatchWorker
from omnimate.service.fleets.webhooks import Deliverer
from omnimate.service.jobs.diagnosing import DiagnosisWorker
from omnimate.service.jobs.housekeeping import Housekeeper
from omnimate.service.robot.robot_process import RobotProcess, spawned
from omnimate.service.robot.session_reporter import SessionReporter
from omnimate.service.store import vehicles
from omnimate.service.store.database import Database
from omnimate.service.store.recordings import FleetStores, RecordingStore
from omnimate.service.vda5050.factsheet import load_factsheet
from omnimate.service.vda5050.publisher import BrokerError, Publisher
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vehicle.file import load_vehicle

if TYPE_CHECKING:
    import asyncio
    from collections.abc import Callable
    from multiprocessing.connection import Connection
    from multiprocessing.process import BaseProcess

    from omnimate.service.settings import Settings
    from omnimate.service.threads import RepeatingThread
    from omnimate.vehicle.parameters import VehicleParameters


class Components:
    """The components of the application, none of them started; `start` starts the robot's process.

    Raises:
        DatabaseError: the database cannot be used.
        VehicleFileError: the vehicle file cannot be read.
        BrokerError: the broker's URL is none, or is given without a factsheet.
        FactsheetError: the factsheet cannot be used.
    """

    def __init__(
        self, settings: Settings, start: Callable[[Connection, Settings, str], BaseProcess] = spawned
    ) -> None:
        vehicle = reference_vehicle() if settings.vehicle is None else load_vehicle(settings.vehicle)
        text = None  # in which EDS files are named as seen from the service, not from the file
        if settings.vehicle is not None and not vehicle.eds_files:
            text = settings.vehicle.read_text(encoding="utf-8-sig")
        database, events = Database(settings.database), EventStream()
        try:
            _store_version(database, vehicle, text)
        except StateError:  # another service that starts at the same time was faster
            _store_version(database, vehicle, text)
        recordings = RecordingStore(database, settings.fleets, settings.unpacked)
        recordings.take_from_rows()
        recordings.delete_orphans(time.time())
        reporter = SessionReporter(database, events.announce, vehicle.name, settings.instance, recordings)
        self.settings, self.vehicle = settings, vehicle.name
        self.database, self.recordings = database, recordings
        self.events, self.reporter = events, reporter
        self.robot = RobotProcess(settings, vehicle.name, events, reporter, start)
        self.stores = FleetStores(settings.fleets)
        self.housekeeper = Housekeeper(database, reporter.announce)
        self.worker = DiagnosisWorker(database, events, settings.instance, recordings)
        self.batch_worker = BatchWorker(database, events, settings, self.stores)
        self.deliverer = Deliverer(database)
        self.publisher = _publisher(settings, self.robot, reporter)
        self.callers = Callers(keyless_allowed=settings.is_loopback)

    def start(self, loop: asyncio.AbstractEventLoop) -> None:
        """Start the robot's process and the threads, and send events on the server's loop."""
        self.events.open(loop)
        self.robot.start()
        for thread in self._threads():
            thread.start()

    def stop(self) -> None:
        """Stop the robot at its next sample and end the streams, without waiting for either."""
        self.robot.reservation.stop("the service was stopped")
        self.events.close()

    def close(self) -> None:
        """Stop the robot, end the threads, and close the database."""
        self.stop()
        self.robot.close()
        for thread in self._threads():
            thread.close()
        self.database.close()

    def _threads(self) -> list[RepeatingThread]:
        """Return the threads other than the robot's."""
        threads: list[RepeatingThread] = [
            self.housekeeper, self.worker, self.batch_worker, self.deliverer,
        ]  # fmt: skip
        return threads if self.publisher is None else [*threads, self.publisher]


def _publisher(settings: Settings, robot: RobotProcess, reporter: SessionReporter) -> Publisher | None:
    """Return who publishes the robot; None where no broker is given."""
    if settings.mqtt is None:
        return None
    if settings.factsheet is None:
        raise BrokerError(
            "--mqtt", "VDA 5050 needs the robot's factsheet, with manufacturer and serial number: --factsheet"
        )
    return Publisher(settings.mqtt, load_factsheet(settings.factsheet), robot, reporter.vehicle)


def _store_version(database: Database, vehicle: VehicleParameters, text: str | None) -> None:
    """Add a version of the robot where its file is new or has changed.

    A file that equals a former version adds none: the calibrations since then started from it.
    """
    with database.writing() as db:
        origin = vehicles.Origin("file")
        if all(row.name != vehicle.name for row in vehicles.newest_of_all(db)):
            vehicles.create(db, vehicle, origin, text)
        elif all(vehicles.parameters_of(row) != vehicle for row in vehicles.versions(db, vehicle.name)):
            vehicles.add_version(db, vehicle, origin, None, text)
