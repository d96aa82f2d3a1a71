"""The settings of the service, read once when it starts."""

from __future__ import annotations

import ipaddress
import secrets
from dataclasses import dataclass, field
from pathlib import Path

MEGABYTE = 1_000_000


@dataclass(frozen=True, slots=True)
class Settings:
    """The settings of the service; the options of `omnimate serve` are called alike."""

    bus: str | None = None  # URL of the robot's bus; None for a simulated robot in the robot's process
    vehicle: Path | None = None  # file of the robot's parameters; None for the reference robot
    database: str = "sqlite:///omnimate.db"  # URL in SQLAlchemy's form
    fleets: str = "fleets"  # folder or URL of all recordings and fleets' results, shared as the database
    jobs: int = 1  # processes that work on a fleet's batch on this machine
    scheduler: str | None = None  # address of the Dask scheduler that works on batches instead
    host: str = "127.0.0.1"  # at which the service listens
    port: int = 8080
    pace: float = 40.0  # of the simulated robot while it drives a session, as a multiple of real time
    lifetime: float = 7 * 86400.0  # [s] after which an unused session expires
    body: int = MEGABYTE  # [bytes], the largest of a call
    upload: int = 200 * MEGABYTE  # [bytes], the largest recording as a zip
    unpacked: int = 1000 * MEGABYTE  # [bytes], the largest recording after it was unpacked
    rate: float = 1000.0  # calls per second that one caller may make, averaged over some seconds
    mqtt: str | None = None  # URL of the broker to which the robot is published by VDA 5050; None for none
    factsheet: Path | None = None  # file of the robot's VDA 5050 factsheet, which publishing needs
    flight_recorder: Path | None = None  # folder for the last minute before each fault, as a recording
    instance: str = field(default_factory=lambda: secrets.token_hex(8))  # id among those of a database

    @property
    def is_loopback(self) -> bool:
        """Whether only this machine can reach the service."""
        if self.host == "localhost":
            return True
        try:
            return ipaddress.ip_address(self.host).is_loopback
        except ValueError:
            return False
