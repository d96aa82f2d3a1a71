"""What the application is made of, started and stopped together."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from sqlalchemy.exc import IntegrityError

from service.access import Callers
from service.hub import Hub
from service.jobs.worker import Worker
from service.robot.desk import Desk
from service.robot.live import Live
from service.robot.rig import simulated_plant
from service.store import vehicles
from service.store.database import Database
from vcan_sim.reference import reference_vehicle
from vehicle.file import format_vehicle, load_vehicle

if TYPE_CHECKING:
    from service.settings import Settings
    from vehicle.parameters import VehicleParameters


@dataclass(frozen=True, slots=True)
class Parts:
    """All parts.

    Attributes:
        settings: that they were made by.
        database: what is remembered.
        hub: who listens.
        vehicle: name of the robot on the bus.
        desk: what the robot's thread writes down.
        live: the robot.
        worker: of the diagnoses.
        callers: who called lately.
    """

    settings: Settings
    database: Database
    hub: Hub
    vehicle: str
    desk: Desk
    live: Live
    worker: Worker
    callers: Callers


def make_parts(settings: Settings) -> Parts:
    """Return the parts, none of them started.

    Raises:
        DatabaseError: the database cannot be used.
        VehicleFileError: the robot's file is wrong.
    """
    given = reference_vehicle() if settings.vehicle is None else load_vehicle(settings.vehicle)
    database, hub = Database(settings.database), Hub()
    try:
        first = _remembered(database, given)
    except IntegrityError:  # another service that starts now was faster
        first = _remembered(database, given)
    plant = simulated_plant(first) if settings.bus is None else None
    desk = Desk(database, hub, given.name, settings.instance)
    live = Live(settings.bus, plant, settings.pace, hub, desk)
    worker = Worker(database, hub, desk, settings.instance, settings.unpacked)
    callers = Callers(open_house=settings.is_loopback)
    return Parts(settings, database, hub, given.name, desk, live, worker, callers)


def _remembered(database: Database, given: VehicleParameters) -> VehicleParameters:
    """Remember a robot that is new, or whose file has changed; return its first version.

    A file that is one of the former versions is what the calibrations since then began with.
    """
    text = format_vehicle(given)
    with database.writing() as db:
        if all(one.name != given.name for one in vehicles.every(db)):
            vehicles.create(db, given, "file")
        elif all(one.toml != text for one in vehicles.versions(db, given.name)):
            vehicles.replace(db, given, "file", None)
        return vehicles.parameters(vehicles.version(db, given.name, 1))
