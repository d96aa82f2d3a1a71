"""The settings of the service, read once when it starts."""

from __future__ import annotations

import ipaddress
import secrets
from dataclasses import dataclass, field
from pathlib import Path

MEGABYTE = 1_000_000


@dataclass(frozen=True, slots=True)
class Settings:
    """The settings of the service.

    Attributes:
        bus: The URL of the robot's bus; None for a simulated robot in the robot's process.
        vehicle: The file of the robot's parameters; None for the reference robot.
        database: The URL of the database, in SQLAlchemy's form.
        fleets: The folder or URL of all recordings, and of the results of fleets; services that share a
            database share it, too.
        jobs: The processes that work on a fleet's batch on this machine.
        scheduler: The address of the Dask scheduler that works on batches; None for this machine.
        host: The address at which the service listens.
        port: The port at which the service listens.
        pace: The pace of the simulated robot while it drives a session, as a multiple of real time.
        lifetime: The time after which an unused session expires [s].
        body: The largest body of a call [bytes].
        upload: The largest recording, as a zip [bytes].
        unpacked: The largest recording after it was unpacked [bytes].
        rate: The calls per second that one caller may make, averaged over some seconds.
        mqtt: The URL of the MQTT broker to which the robot is published by VDA 5050; None for none.
        factsheet: The file of the robot's VDA 5050 factsheet, which publishing needs.
        flight_recorder: The folder for the last minute before each fault, as a recording; None for none.
        instance: The id of this service among the services that share a database.
    """

    bus: str | None = None
    vehicle: Path | None = None
    database: str = "sqlite:///omnimate.db"
    fleets: str = "fleets"
    jobs: int = 1
    scheduler: str | None = None
    host: str = "127.0.0.1"
    port: int = 8080
    pace: float = 40.0
    lifetime: float = 7 * 86400.0
    body: int = MEGABYTE
    upload: int = 200 * MEGABYTE
    unpacked: int = 1000 * MEGABYTE
    rate: float = 1000.0
    mqtt: str | None = None
    factsheet: Path | None = None
    flight_recorder: Path | None = None
    instance: str = field(default_factory=lambda: secrets.token_hex(8))

    @property
    def is_loopback(self) -> bool:
        """Whether only this machine can reach the service."""
        if self.host == "localhost":
            return True
        try:
            return ipaddress.ip_address(self.host).is_loopback
        except ValueError:
            return False
