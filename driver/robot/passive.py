"""Listens to a bus on which another master or a replay produces SYNC, or on which encoders need none.

Nothing is sent. As in a log (`omnimate.files.logs.assemble`), a sample begins with SYNC; where there is
none, with the PDO of the vehicle that came first, or another one while that is silent.
"""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING, Self

from omnimate.driver.bus.bus import open_bus
from omnimate.driver.bus.clock import WallClock
from omnimate.driver.canopen.network import BusNetwork
from omnimate.driver.errors import BusError, BusLost, NoSync
from omnimate.driver.robot.monitor import Monitor
from omnimate.driver.robot.report import DriverReport, make_report
from omnimate.files.logs.canopen_words import HEARTBEAT, NMT_ID, NMT_START, SDO_REQUEST, SYNC_ID
from omnimate.vehicle.assembly import SampleOpener

if TYPE_CHECKING:
    from collections.abc import Iterator

    import can

    from omnimate.driver.bus.clock import Clock
    from omnimate.driver.canopen.network import FrameSink
    from omnimate.vehicle.parameters import VehicleParameters
    from omnimate.vehicle.sample import Sample

LAST_WAIT = 0.2  # [s] in which a sample at the end of the time is still closed by the next one
SYNC_WAIT = 1.0  # [s] from the first PDO to SYNC, at the latest; masters produce ten per second or more


class PassiveReader:
    """Assembles samples from frames that others exchange; times are those of arrival, as wall time."""

    def __init__(
        self,
        vehicle: VehicleParameters,
        bus: can.BusABC | str,
        *,
        recorder: FrameSink | None = None,
        clock: Clock | None = None,
    ) -> None:
        """Open the bus where it is given as a URL.

        Args:
            vehicle: Vehicle whose encoders are read.
            bus: URL of the bus, or a bus that the caller owns.
            recorder: Gets every frame that is received; None for none.
            clock: Gives the times of samples and events; None for wall time.

        Raises:
            BusError: The URL's bus cannot be opened.
        """
        self.vehicle = vehicle
        self._url = bus if isinstance(bus, str) else None
        self._clock = clock or WallClock(vehicle.bus.sync_period)
        self._network = BusNetwork(
            open_bus(bus, vehicle.bus.bitrate) if isinstance(bus, str) else bus, self._clock, recorder
        )
        self._monitor = Monitor(vehicle, self._clock)
        self._network.on_unrecorded = self._monitor.events.unrecorded
        nodes = vehicle.nodes
        masters = {
            NMT_ID,
            *(drive.cob_id for drive in vehicle.drives),
            *(SDO_REQUEST + node for node in nodes),
        }
        masters |= {HEARTBEAT + node for node in range(1, 128) if node not in nodes}
        self._monitor.others = masters.__contains__
        for node in nodes:
            self._monitor.supervision.started(node, None)
        self._seconds = math.inf  # [s] after which the source counts as ended
        self._syncs = 0
        self._opener: SampleOpener | None = None  # once it is known
        self._first: tuple[int, float] | None = None  # COB-ID of the first PDO, and when it came

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()

    def end_after(self, seconds: float | None) -> None:
        """End `samples` so long after it began to wait, then after the first SYNC or PDO [s]; None: never."""
        self._seconds = math.inf if seconds is None else seconds

    def samples(self, idle: float = 2.0, patience: float = 30.0) -> Iterator[Sample]:
        """Yield a sample per SYNC, each when the next SYNC shows that it is over.

        Without SYNC within `SYNC_WAIT` after the first PDO, that PDO takes its place, and while it is silent
        another one (`omnimate.vehicle.assembly.SampleOpener`).

        Args:
            idle: Time without a SYNC after which the source counts as ended [s].
            patience: Time in which the first SYNC or PDO must come, and after which a bus without SYNC on
                which nothing is sent counts as ended [s].

        Raises:
            NoSync: There was neither SYNC nor a PDO of the vehicle.
            BusError: The interface failed.
        """
        assembler = self._monitor.assembler
        for message, arrival in self._frames(idle, patience):
            if self._opens(_identifier(message), arrival):
                if assembler.is_open:
                    yield self._close()
                self._begin(arrival)
                if message.arbitration_id == SYNC_ID:
                    continue
            if message.arbitration_id == NMT_ID and bytes(message.data[:1]) == bytes([NMT_START]):
                assembler.node_started(message.data[1] if len(message.data) == 2 else 0)
            self._monitor.take(message, arrival)
        if not self._syncs:
            raise NoSync(min(patience, self._seconds))
        yield self._close()

    def _frames(self, idle: float, patience: float) -> Iterator[tuple[can.Message, float]]:
        """Yield frames and when they were on the bus, as soon as it is known if they open a sample."""
        early: list[tuple[can.Message, float]] = []
        last_heard = time.monotonic()
        end = last_heard + self._seconds
        while True:
            has_sync = self._opener is not None and self._opener.identifier == SYNC_ID
            silence = idle if has_sync else patience
            left = min(last_heard + silence, end) - time.monotonic()
            if left <= 0.0:
                break
            message = self._receive(min(idle, SYNC_WAIT, left))
            identifier = None if message is None else _identifier(message)
            if message is not None:
                early.append((message, self._network.arrival))
            if self._opener is None:
                self._opener = self._find_opener(identifier)
                if self._opener is not None:
                    end = time.monotonic() + self._seconds + LAST_WAIT
            is_heard = identifier == SYNC_ID or (message is not None and not has_sync)
            if self._opener is not None and is_heard:
                last_heard = time.monotonic()
            if self._opener is not None or self._first is None:  # only what follows a first PDO has to wait
                yield from early
                early.clear()
        for message, arrival in early:  # no sample was opened for them; they are counted all the same
            self._monitor.take(message, arrival)

    def _find_opener(self, identifier: int | None) -> SampleOpener | None:
        """Return SYNC where it comes, else the vehicle's first PDO once `SYNC_WAIT` has passed since then."""
        if identifier == SYNC_ID:
            return SampleOpener(SYNC_ID)
        is_first = self._first is None and identifier in self._monitor.assembler.cob_ids
        if is_first and identifier is not None:
            self._first = (identifier, time.monotonic())
        if self._first is None or time.monotonic() - self._first[1] < SYNC_WAIT:
            return None
        self._monitor.assembler.is_synchronous = False
        return SampleOpener(self._first[0], self._monitor.assembler.cob_ids)

    def _opens(self, identifier: int | None, now: float) -> bool:
        """Return whether a frame opens a sample; report where another PDO does so from now on."""
        if self._opener is None or identifier is None:
            return False
        before = self._opener.identifier
        opens = self._opener.opens(identifier)
        if self._opener.identifier != before:
            node = next(encoder.node for encoder in self.vehicle.encoders if encoder.cob_id == before)
            silent, other = f"PDO {before:03X}h", f"PDO {identifier:03X}h"
            what = f"{silent} is silent, or ten times slower than {other}: samples begin with {other}"
            self._monitor.events.add(now, node, what)
        return opens

    def report(self) -> DriverReport:
        """Return the counters, events and gaps so far."""
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

    def _begin(self, now: float) -> None:
        self._monitor.assembler.begin(self._syncs, now)
        self._monitor.synced(now)
        self._monitor.check(now)
        self._syncs += 1

    def _close(self) -> Sample:
        supervision = self._monitor.supervision
        sample = self._monitor.assembler.close()
        supervision.troubles.clear()
        for node in self._monitor.assembler.take_silent():
            if self._monitor.assembler.never_answered(node):
                self._monitor.report_unanswered(node, "check that it is there and started")
        return sample


def _identifier(message: can.Message) -> int | None:
    """Return the identifier of a classic data frame of 11 bits, None for any other."""
    is_other = message.is_extended_id or message.is_remote_frame or message.is_error_frame or message.is_fd
    return None if is_other else message.arbitration_id
