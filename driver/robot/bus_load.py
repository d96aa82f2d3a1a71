"""Forecasts the load of the bus before anything is configured."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from omnimate.driver.canopen.node_setup import DRIVE_HEARTBEAT_MS, HEARTBEAT_MS
from omnimate.driver.errors import BusOverload
from omnimate.driver.robot.status_words import STATUS_AGE
from omnimate.vehicle.assembly import pdo_lengths

if TYPE_CHECKING:
    from collections.abc import Iterable

    from omnimate.vehicle.parameters import VehicleParameters

WARN, REFUSE = 0.60, 0.80  # shares of the bus: choices of the driver; no standard states them
TARGET_BYTES, SDO_BYTES = 4, 8  # 60FFh; a request or an answer


def frame_bits(length: int, *, stuffed: bool, extended: bool = False) -> int:
    """Return the bits of a classic frame with the space between frames: 47 + 8 n (ISO 11898-1).

    Args:
        length: Number n of data bytes.
        stuffed: Whether to add the largest possible number of stuff bits, floor((33 + 8 n) / 4).
        extended: Whether it has a 29-bit identifier, and so 20 bits more, which may be stuffed too.
    """
    head = 20 if extended else 0
    bits = 47 + head + 8 * length
    return bits + (33 + head + 8 * length) // 4 if stuffed else bits


@dataclass(frozen=True, slots=True)
class BusLoad:
    """Forecast share of the bus in use; 1 is full."""

    bitrate: int  # bit rate of the bus [bit/s]
    least: float  # share without stuff bits
    worst: float  # share with every possible stuff bit

    @property
    def is_high(self) -> bool:
        """Whether the load deserves a warning: the worst case is above 60 %."""
        return self.worst > WARN

    def in_words(self) -> str:
        """Return the forecast as a sentence."""
        text = f"bus load forecast {self.least:.0%} to {self.worst:.0%} of {self.bitrate} bit/s"
        return f"{text}; above {WARN:.0%}: PDOs may come late" if self.is_high else text


def forecast_load(vehicle: VehicleParameters) -> BusLoad:
    """Return the load of SYNC, TPDOs, RPDOs sent with every SYNC, heartbeats, and status words by SDO."""
    drives = {drive.node for drive in vehicle.drives}
    others = len(set(vehicle.nodes) - drives) + 1  # and the driver
    rate = 1.0 / vehicle.bus.sync_period
    frames = [(0, rate)]
    frames += [(length, rate) for length in pdo_lengths(vehicle).values()]
    frames += [(TARGET_BYTES + drive.start_bit // 8, rate) for drive in vehicle.drives]
    frames += [(1, 1000.0 / HEARTBEAT_MS)] * others
    frames += [(1, 1000.0 / DRIVE_HEARTBEAT_MS), (SDO_BYTES, 2.0 / STATUS_AGE)] * len(drives)
    return BusLoad(
        vehicle.bus.bitrate,
        _share(frames, vehicle.bus.bitrate, stuffed=False),
        _share(frames, vehicle.bus.bitrate, stuffed=True),
    )


def check_load(load: BusLoad) -> None:
    """Raise BusOverload where the worst case of a forecast is above `REFUSE`."""
    if load.worst > REFUSE:
        raise BusOverload(load.worst, REFUSE, load.bitrate)


def _share(frames: Iterable[tuple[int, float]], bitrate: int, *, stuffed: bool) -> float:
    """Return the share of the bus for frames of so many bytes, each with its rate [1/s]."""
    return sum(frame_bits(length, stuffed=stuffed) * rate for length, rate in frames) / bitrate
