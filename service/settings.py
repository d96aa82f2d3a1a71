"""What the service is told at its start; read once, never changed."""

from __future__ import annotations

import ipaddress
import secrets
from dataclasses import dataclass, field
from pathlib import Path

MEGABYTE = 1_000_000


@dataclass(frozen=True, slots=True)
class Settings:
    """All of it.

    Attributes:
        bus: URL of the robot's bus; None for a simulated robot in this process.
        vehicle: file of the robot's parameters; None for the reference robot.
        database: URL of SQLAlchemy.
        host: to listen at.
        port: likewise.
        pace: of the simulated robot while it drives a session, in real times.
        lifetime: how long nobody may go on with a session before it expires [s].
        body: largest body of a call [bytes].
        upload: largest recording as a zip [bytes].
        unpacked: largest recording when it is unpacked [bytes].
        rate: calls a second that one caller may make, over some seconds.
        instance: of this process, among services that share a database.
    """

    bus: str | None = None
    vehicle: Path | None = None
    database: str = "sqlite:///omnimate.db"
    host: str = "127.0.0.1"
    port: int = 8080
    pace: float = 40.0
    lifetime: float = 7 * 86400.0
    body: int = MEGABYTE
    upload: int = 200 * MEGABYTE
    unpacked: int = 1000 * MEGABYTE
    rate: float = 1000.0
    instance: str = field(default_factory=lambda: secrets.token_hex(8))

    @property
    def is_loopback(self) -> bool:
        """Whether nobody but this machine can reach the service."""
        if self.host == "localhost":
            return True
        try:
            return ipaddress.ip_address(self.host).is_loopback
        except ValueError:
            return False
