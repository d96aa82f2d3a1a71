"""Receives from a bus in a background thread, and sends nothing.

At every `REFRESH` it makes a `Snapshot`, which is immutable, so that any thread may read it.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, Self, cast

import can

from omnimate.driver.bus.clock import WallClock
from omnimate.driver.bus.replay import LogBus
from omnimate.driver.errors import BusError, in_one_line
from omnimate.driver.robot.bus_load import frame_bits
from omnimate.driver.robot.events import EventLog
from omnimate.driver.robot.recorder import Recorder
from omnimate.driver.robot.robot_watch import SPAN, RobotWatch
from omnimate.files.logs.bus_events import BusEvents
from omnimate.files.logs.formats.candump_writer import CandumpWriter
from omnimate.files.logs.formats.python_can_logs import frame_of_message
from omnimate.files.logs.frames import ERROR, EXTENDED, FD
from omnimate.files.logs.live_table import LiveTable
from omnimate.files.logs.seen_mapping import SeenObjects
from omnimate.vehicle.errors import OmnimateError, RecordingError

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from omnimate.driver.robot.events import Event
    from omnimate.driver.robot.robot_watch import RobotView
    from omnimate.files.logs.bus_events import NodeSeen
    from omnimate.files.logs.live_table import LiveRow
    from omnimate.vehicle.parameters import VehicleParameters

REFRESH = 0.25  # [s] between two snapshots
POLL = 0.1  # [s] after which a silent bus is asked again
AGAIN = 1.0  # [s] between two attempts to open a bus that was lost
_BITS = {
    (extended, stuffed): [frame_bits(length, stuffed=stuffed, extended=extended) for length in range(9)]
    for extended in (False, True)
    for stuffed in (False, True)
}
Opener = Callable[[], can.BusABC]


class Traffic(NamedTuple):
    """How full the bus is."""

    rate: float  # frames per second
    least: float  # bits per second of classical frames without stuff bits
    most: float  # bits per second of classical frames with every possible stuff bit


@dataclass(frozen=True, slots=True)
class Snapshot:
    """The bus at one moment."""

    time: float  # when it was taken, as wall time [s], or the time in a log that is replayed
    since: float  # time since the watch began [s]
    frames: int  # number of frames so far
    left_out: int  # number of frames that are none, or of identifiers beyond those that are counted
    traffic: Traffic  # how full the bus is
    rows: tuple[LiveRow, ...]  # frames by identifier
    # last reported NMT state of each node, by interface and node id
    nodes: Mapping[tuple[str, int], NodeSeen]
    events: tuple[Event, ...]  # events in order of time
    # PDO parameters that SDO traffic showed, by node, index and sub-index
    seen: Mapping[tuple[int, int, int], int]
    robot: RobotView | None  # where the robot is; None without a vehicle or before the first sample
    lost: str | None  # why the bus cannot be read now; None where it can
    recording: Path | None  # folder or file that is being recorded; None where none is
    has_ended: bool  # whether it was a log, and its last frame was received


class _Clock(WallClock):
    """Wall time, or the time in a log that is replayed."""

    def __init__(self, watch: BusWatch) -> None:
        super().__init__(REFRESH)
        self._watch = watch

    def now(self) -> float:
        """Return the time [s]."""
        bus = self._watch.bus
        return bus.now() if isinstance(bus, LogBus) else super().now()

    def frame_time(self, stamp: float) -> float:
        """Return when a frame was on the bus [s]; in a log its stamp says it."""
        return stamp if isinstance(self._watch.bus, LogBus) else super().frame_time(stamp)


class BusWatch:
    """Receives from a bus in a background thread; makes a new `snapshot` at every `REFRESH`."""

    def __init__(self, opened: Opener, vehicle: VehicleParameters | None = None) -> None:
        """Open the bus by `opened`, and again after it was lost; raises BusError."""
        self.vehicle = vehicle
        self._opened = opened
        self.bus: can.BusABC = opened()
        self._stop = threading.Event()
        self._table, self._events, self._log = LiveTable(), BusEvents(), EventLog()
        self._left_out = 0
        self._least = self._most = 0
        self._seen = SeenObjects()
        self._supervised = () if vehicle is None else vehicle.nodes
        self._robot = None if vehicle is None else RobotWatch(vehicle)
        self._recorder: Recorder | CandumpWriter | None = None
        self._target: Path | None = None  # folder or log of the recorder
        self._wanted_target: Path | None = None  # where to record; None for nowhere
        self._lost: str | None = None
        self._clock = _Clock(self)
        self._began = self._clock.now()
        self._taken = time.monotonic()
        self._marks: deque[tuple[float, int, int, int]] = deque(maxlen=SPAN + 1)
        self.snapshot = self._take_snapshot()
        self._thread = threading.Thread(target=self._run, name="bus watch", daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_error: object) -> None:
        self._stop.set()
        self._thread.join()
        self.bus.shutdown()

    @property
    def is_running(self) -> bool:
        """Whether frames are still received."""
        return self._thread.is_alive()

    def record(self, target: Path | None) -> None:
        """Record from now on into a folder, or without a vehicle into a candump log; None ends it."""
        self._wanted_target = target

    def recv(self, timeout: float | None = None) -> can.Message | None:
        """Return the next frame, or None after `POLL` at the latest; what a reader takes for its bus.

        Raises can.CanOperationError where the watch is to end, or the bus was lost.
        """
        if self._stop.is_set():
            raise can.CanOperationError("the watch has ended")
        if self._wanted_target != self._target:
            self._switch_recording(self._wanted_target)
        if time.monotonic() - self._taken >= REFRESH:  # the last frame is taken by now, a next one is not
            self._taken = time.monotonic()
            self.snapshot = self._take_snapshot()
        return self.bus.recv(POLL if timeout is None else min(timeout, POLL))

    def _run(self) -> None:
        """Follow the bus until the watch ends; open it again after it was lost."""
        while not self._stop.is_set():
            try:
                self._follow()
            except (can.CanError, OSError, OmnimateError) as error:
                if not self._stop.is_set():
                    self._reopen(in_one_line(error))
        self._switch_recording(None)
        self.snapshot = self._take_snapshot()

    def _follow(self) -> None:
        """Receive until the bus fails or the watch ends."""
        if self._robot is not None:
            self._robot.follow(cast("can.BusABC", self), self, self._clock)
        while True:
            message = self.recv()
            if message is not None:
                self.frame(self._clock.frame_time(message.timestamp), message)

    def _reopen(self, why: str) -> None:
        self._log.add(self._clock.now(), None, f"bus lost: {why}", is_problem=True)
        self._lost = why
        while not self._stop.is_set():
            self.snapshot = self._take_snapshot()
            try:
                self.bus.shutdown()
                self.bus = self._opened()
            except (can.CanError, OSError, BusError):
                self._stop.wait(AGAIN)
            else:
                self._lost = None
                self._log.add(self._clock.now(), None, "bus is back; what happened meanwhile was not seen")
                return

    def use(self, vehicle: VehicleParameters) -> None:
        """Ignore the ranges that encoders report; the watch reads none."""

    def frame(self, at: float, message: can.Message) -> None:
        """Take a frame that was on the bus at `at` [s]."""
        frame = frame_of_message(message, fd=True)
        if isinstance(frame, str):
            self._left_out += 1
            return
        self._table.take(frame, at)
        if not frame.flags & (FD | ERROR):
            extended, length = bool(frame.flags & EXTENDED), len(frame.data)
            self._least += _BITS[extended, False][length]
            self._most += _BITS[extended, True][length]
        event = self._events.take(frame)
        if event is not None and not (event.is_health and event.node in self._supervised):
            self._log.add(at, event.node, event.what, is_problem=event.is_problem)
        self._seen.take_frame(frame)
        try:
            if isinstance(self._recorder, Recorder):
                self._recorder.frame(at, message)
            elif self._recorder is not None:
                self._recorder.write_frame(frame._replace(time=at))
        except OSError as error:
            self._log.unrecorded(at, error)

    def _switch_recording(self, target: Path | None) -> None:
        if self._recorder is not None:
            try:
                self._recorder.close()
                self._log.add(self._clock.now(), None, f"recorded: {self._target}")
            except (OSError, RecordingError) as error:
                self._log.add(self._clock.now(), None, in_one_line(error), is_problem=True)
            self._recorder = self._target = None
        if target is None:
            return
        try:
            self._recorder = CandumpWriter(target) if self.vehicle is None else Recorder(target, self.vehicle)
            self._target = target
        except (OSError, OmnimateError) as error:
            self._wanted_target = None
            self._log.add(self._clock.now(), None, in_one_line(error), is_problem=True)

    def _take_snapshot(self) -> Snapshot:
        now = self._clock.now()
        if not self._marks or now > self._marks[-1][0]:
            self._marks.append((now, self._table.frames, self._least, self._most))
        return Snapshot(
            now,
            now - self._began,
            self._table.frames,
            self._left_out + self._table.others,
            self._traffic(),
            self._table.rows(now),
            dict(self._events.nodes),
            self._all_events(),
            dict(self._seen.values),
            None if self._robot is None else self._robot.view(),
            self._lost,
            self._target,
            isinstance(self.bus, LogBus) and self.bus.ended,
        )

    def _all_events(self) -> tuple[Event, ...]:
        """Return the events of the bus and of the robot's nodes, in order of their last time."""
        events = self._log.all()
        if self._robot is not None:
            events += self._robot.events()
        return tuple(sorted(events, key=lambda event: event.last))

    def _traffic(self) -> Traffic:
        first, last = self._marks[0], self._marks[-1]
        passed = last[0] - first[0]
        if passed <= 0.0:
            return Traffic(0.0, 0.0, 0.0)
        return Traffic(
            *((after - before) / passed for before, after in zip(first[1:], last[1:], strict=True))
        )
