"""The bus as the driver uses it: every frame sent or received passes here, in order, and is recorded."""

from __future__ import annotations

import errno
import logging
import threading
import time
from typing import TYPE_CHECKING, Protocol

import can
from canopen import Network

from omnimate.driver.bus.bus import receive
from omnimate.driver.canopen.dictionary import standard_dictionary
from omnimate.driver.canopen.sdo import Sdo
from omnimate.driver.errors import BusLost
from omnimate.files.logs.canopen_words import NMT_ID, SDO_ANSWER, SYNC_ID
from omnimate.vehicle.parameters import SDO_TIMEOUT

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from canopen.objectdictionary import ObjectDictionary

    from omnimate.driver.bus.clock import Clock
    from omnimate.vehicle.parameters import VehicleParameters

# [s] in which a full queue (ENOBUFS; ten frames are SocketCAN's default) has long been sent at 125 kbit/s,
# and between two looks. Where nothing acknowledges frames, or after bus-off, it stays full.
QUEUE_TIME, QUEUE_STEP = 0.03, 0.0005
LONGEST_WAIT = 0.05  # [s] for one frame, where something is due while an answer is awaited

# What canopen logs is raised here as an error of the driver, with the node and the words.
logging.getLogger("canopen").addHandler(logging.NullHandler())


class FrameSink(Protocol):
    """Where frames go to be recorded; called from several threads, one at a time."""

    def use(self, vehicle: VehicleParameters) -> None:
        """Take the vehicle as its encoders describe it."""
        ...

    def frame(self, at: float, message: can.Message) -> None:
        """Take a frame as it was sent or received at `at` [s].

        Raises:
            OSError: It cannot be recorded; the driver reports that, and goes on.
        """
        ...


class BusNetwork(Network):
    """canopen's network on a bus with a clock and a recorder; no thread reads it in the background."""

    def __init__(self, bus: can.BusABC, clock: Clock, recorder: FrameSink | None = None) -> None:
        super().__init__(bus)
        self.can_bus = bus  # sends and receives
        self.clock = clock  # of the recording
        self.recorder = recorder  # gets every frame that is sent or received; None for none
        # gets every frame that `pump` reads, with the time at which it was on the bus [s]; by default those
        # who have subscribed to its identifier get it
        self.handler: Callable[[can.Message, float], None] = lambda message, _arrival: self.notify(
            message.arbitration_id, message.data, message.timestamp
        )
        # called before each wait of `pump`, which then ends after `LONGEST_WAIT`; None for nothing
        self.on_wait: Callable[[], None] | None = None
        # called with the time of a frame [s] that the recorder could not take, and why
        self.on_unrecorded: Callable[[float, OSError], None] = lambda _at, _error: None
        self.arrival = 0.0  # when the last frame received was on the bus, on the recording's clock [s]
        self._lock = threading.Lock()
        self._sync = can.Message(arbitration_id=SYNC_ID, is_extended_id=False, is_rx=False)

    def replace_bus(self, bus: can.BusABC) -> None:
        """Use another bus from now on, after the first was lost."""
        self.bus = self.can_bus = bus

    def sdo(
        self,
        node: int,
        dictionaries: Mapping[int, ObjectDictionary] | None = None,
        timeout: float = SDO_TIMEOUT,
    ) -> Sdo:
        """Return the objects of a node, whose answers are awaited for `timeout` [s] each.

        They have the dictionary of the node's EDS where there is one, else the standard one.
        """
        dictionary = (dictionaries or {}).get(node) or standard_dictionary()
        sdo = Sdo(node, dictionary, self, self.pump)
        sdo.RESPONSE_TIMEOUT = timeout
        self.subscribe(SDO_ANSWER + node, sdo.on_response)
        return sdo

    def send_message(self, can_id: int, data: bytes, remote: bool = False) -> None:
        """Send a frame with an 11-bit identifier; canopen sends through this method too; raises BusLost."""
        self._send(
            can.Message(
                arbitration_id=can_id, data=data, is_extended_id=False, is_remote_frame=remote, is_rx=False
            ),
            None,
        )

    def send_sync(self, at: float) -> None:
        """Send SYNC, whose time is `at` [s]; raises BusLost."""
        self._send(self._sync, at)

    def nmt_command(self, command: int, node: int) -> None:
        """Send an NMT command to a node, 0 for all; raises BusLost."""
        self.send_message(NMT_ID, bytes((command, node)))

    def receive(self, timeout: float) -> can.Message | None:
        """Return the next frame, or None when `timeout` [s] has passed; raises BusLost."""
        message = receive(self.can_bus, timeout)
        if message is None:
            return None
        self.arrival = self.clock.frame_time(message.timestamp)
        if self.recorder is not None:
            with self._lock:
                self._record(self.recorder, self.arrival, message)
        return message

    def pump(self, timeout: float) -> None:
        """Receive one frame, if one comes within `timeout` [s], and hand it to `handler`; raises BusLost."""
        if self.on_wait is not None:
            self.on_wait()
            timeout = min(timeout, LONGEST_WAIT)
        message = self.receive(timeout)
        if message is not None:
            self.handler(message, self.arrival)

    def _send(self, message: can.Message, at: float | None) -> None:
        with self._lock:
            self._put(message)
            if self.recorder is not None:
                self._record(self.recorder, self.clock.now() if at is None else at, message)

    def _record(self, recorder: FrameSink, at: float, message: can.Message) -> None:
        """Record a frame where that is possible: a robot drives on when its disk is full."""
        try:
            recorder.frame(at, message)
        except OSError as error:
            self.on_unrecorded(at, error)

    def _put(self, message: can.Message) -> None:
        """Hand a frame to the interface; wait while its queue is full; raises BusLost if it stays full."""
        end = time.monotonic() + QUEUE_TIME
        while True:
            try:
                self.can_bus.send(message)
            except (can.CanError, OSError) as error:
                number = error.error_code if isinstance(error, can.CanError) else error.errno
                if number != errno.ENOBUFS or time.monotonic() >= end:
                    raise BusLost(error) from error
                time.sleep(QUEUE_STEP)
            else:
                return
