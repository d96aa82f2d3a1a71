"""How full the bus will be, before anything is configured."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from driver.errors import BusOverload

if TYPE_CHECKING:
    from collections.abc import Iterable

    from vehicle.parameters import VehicleParameters

WARN, REFUSE = 0.60, 0.80
RPDO_BYTES = 4  # 60FFh


def frame_bits(length: int, *, stuffed: bool) -> int:
    """Return the bits of a classic 11-bit frame with `length` data bytes, with the space between frames.

    47 + 8 n; at worst floor((33 + 8 n) / 4) stuff bits more (ISO 11898-1).
    """
    bits = 47 + 8 * length
    return bits + (33 + 8 * length) // 4 if stuffed else bits


@dataclass(frozen=True, slots=True)
class BusLoad:
    """Forecast shares of the bus, 1 is full.

    Attributes:
        bitrate: [bit/s].
        least: without stuff bits.
        worst: with every possible stuff bit.
    """

    bitrate: int
    least: float
    worst: float

    @property
    def is_high(self) -> bool:
        """Whether it deserves a warning."""
        return self.worst > WARN

    def in_words(self) -> str:
        """Return the forecast as a sentence."""
        text = f"bus load forecast {self.least:.0%} to {self.worst:.0%} of {self.bitrate} bit/s"
        return f"{text}; above {WARN:.0%}: PDOs may come late" if self.is_high else text


def forecast(vehicle: VehicleParameters, heartbeat: float) -> BusLoad:
    """Return the load of SYNC, TPDOs, RPDOs sent with every SYNC, and heartbeats every `heartbeat` [s]."""
    rate = 1.0 / vehicle.bus.sync_period
    nodes = {encoder.node for encoder in vehicle.encoders} | {drive.node for drive in vehicle.drives}
    frames = [(0, rate)]
    frames += [(length, rate) for length in pdo_lengths(vehicle).values()]
    frames += [(RPDO_BYTES, rate)] * len(vehicle.drives)
    frames += [(1, 1.0 / heartbeat)] * (len(nodes) + 1)
    return BusLoad(
        vehicle.bus.bitrate,
        _share(frames, vehicle.bus.bitrate, stuffed=False),
        _share(frames, vehicle.bus.bitrate, stuffed=True),
    )


def check(load: BusLoad) -> None:
    """Refuse a forecast that leaves no room.

    Raises:
        BusOverload: the worst case is above 80 %.
    """
    if load.worst > REFUSE:
        raise BusOverload(load.worst, REFUSE, load.bitrate)


def pdo_lengths(vehicle: VehicleParameters) -> dict[int, int]:
    """Return the bytes that each TPDO of the vehicle needs, by COB-ID."""
    ends: dict[int, int] = {}
    for encoder in vehicle.encoders:
        ends[encoder.cob_id] = max(ends.get(encoder.cob_id, 0), encoder.start_bit + encoder.bits)
    return {cob_id: (end + 7) // 8 for cob_id, end in ends.items()}


def _share(frames: Iterable[tuple[int, float]], bitrate: int, *, stuffed: bool) -> float:
    return sum(frame_bits(length, stuffed=stuffed) * rate for length, rate in frames) / bitrate
