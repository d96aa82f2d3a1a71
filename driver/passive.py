"""Listens to a bus on which another master or a replay produces SYNC. Sends nothing."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Self

from omnimate.driver.bus import open_bus
from omnimate.driver.clock import WallClock
from omnimate.driver.errors import BusError, BusLost, NoSync
from omnimate.driver.monitor import Monitor
from omnimate.driver.network import SYNC_ID, BusNetwork
from omnimate.driver.node_counts import nodes_of
from omnimate.driver.report import DriverReport, make_report

if TYPE_CHECKING:
    from collections.abc import Iterator

    import can

    from omnimate.driver.network import FrameSink
    from omnimate.vehicle.parameters import VehicleParameters
    from omnimate.vehicle.sample import Sample

NMT_ID, SDO_REQUEST, HEARTBEAT = 0x000, 0x600, 0x700
NMT_START = b"\x01"


class PassiveReader:
    """Assembles samples from frames that others exchange; times are those of arrival, as wall time.

    Attributes:
        vehicle: Vehicle whose encoders are read.
    """

    def __init__(
        self, vehicle: VehicleParameters, bus: can.BusABC | str, *, recorder: FrameSink | None = None
    ) -> None:
        """Open the bus where it is given as a URL.

        Args:
            vehicle: Vehicle whose encoders are read.
            bus: URL of the bus, or a bus that the caller owns.
            recorder: Gets every frame that is received; None for none.

        Raises:
            BusError: The URL's bus cannot be opened.
        """
        self.vehicle = vehicle
        self._url = bus if isinstance(bus, str) else None
        self._clock = WallClock(vehicle.bus.sync_period)
        self._network = BusNetwork(
            open_bus(bus, vehicle.bus.bitrate) if isinstance(bus, str) else bus, self._clock, recorder
        )
        self._monitor = Monitor(vehicle, self._clock)
        nodes = nodes_of(vehicle)
        masters = {
            NMT_ID,
            *(drive.cob_id for drive in vehicle.drives),
            *(SDO_REQUEST + node for node in nodes),
        }
        masters |= {HEARTBEAT + node for node in range(1, 128) if node not in nodes}
        self._monitor.others = masters.__contains__
        for node in nodes:
            self._monitor.supervision.started(node, None)
        self._syncs = 0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()

    def samples(self, idle: float = 2.0, patience: float = 30.0) -> Iterator[Sample]:
        """Yield a sample per SYNC, each when the next SYNC shows that it is over.

        Args:
            idle: Time without a SYNC after which the source counts as ended [s].
            patience: Time in which the first SYNC must come [s].

        Raises:
            NoSync: There was no SYNC at all.
            BusError: The interface failed.
        """
        assembler, heard = self._monitor.assembler, time.monotonic()
        while time.monotonic() - heard < (idle if self._syncs else patience):
            message = self._receive(idle)
            if message is None:
                continue
            if message.arbitration_id == SYNC_ID and not message.is_extended_id:
                if assembler.is_open:
                    yield self._close()
                heard = time.monotonic()
                self._begin()
            else:
                if message.arbitration_id == NMT_ID and bytes(message.data[:1]) == NMT_START:
                    self._monitor.assembler.node_started(message.data[1] if len(message.data) == 2 else 0)
                self._monitor.take(message, self._network.arrival)
        if not self._syncs:
            raise NoSync(patience)
        yield self._close()

    def report(self) -> DriverReport:
        """Return what has been heard so far."""
        return make_report(self.vehicle, self._monitor, self._syncs)

    def close(self) -> None:
        """Close the bus if it was given as a URL."""
        if self._url is not None:
            self._network.can_bus.shutdown()

    def _receive(self, timeout: float) -> can.Message | None:
        try:
            return self._network.receive(timeout)
        except BusLost as lost:
            raise BusError(self._url or "bus", str(lost)) from lost

    def _begin(self) -> None:
        now = self._clock.now()
        self._monitor.assembler.begin(self._syncs, now, self._network.arrival)
        self._monitor.synced(now)
        self._monitor.check(now)
        self._syncs += 1

    def _close(self) -> Sample:
        supervision = self._monitor.supervision
        sample = self._monitor.assembler.close()
        supervision.troubles.clear()
        for node in self._monitor.assembler.take_silent():
            if self._monitor.assembler.never_answered(node):
                self._monitor.trouble("has never answered SYNC: check that it is there and started", node)
        return sample
