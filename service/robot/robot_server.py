"""The robot's process: the robot's loop, and a pipe to the process that answers REST."""

from __future__ import annotations

import gc
import logging
import queue
import signal
import sys
import threading
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from omnimate.service.request_log import log_as_json
from omnimate.service.robot.connection import simulated_plant
from omnimate.service.robot.robot_thread import RobotThread
from omnimate.service.robot.session_reporter import SessionReporter
from omnimate.service.store import vehicles
from omnimate.service.store.database import Database
from omnimate.service.store.recordings import RecordingStore

if TYPE_CHECKING:
    from collections.abc import Callable
    from multiprocessing.connection import Connection

    from omnimate.driver.robot.report import DriverReport
    from omnimate.service.settings import Settings

REPORT_PERIOD = 0.05  # [s] between two reports to the process that answers REST
GC_THRESHOLDS = 20_000, 20, 20  # of gc.set_threshold: fewer collections, each of which stops all threads
SWITCH_INTERVAL = 0.0002  # [s] for which one thread may run while others wait
_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class RobotStatus:
    """The robot as its process reported it last."""

    problem: str | None = "starting"  # why the robot cannot be read; None where it can
    session: str | None = None  # id of the session that the robot is reserved for; None where it is free
    state: dict[str, Any] = field(default_factory=dict)  # the last `state` event
    report: DriverReport | None = None  # the driver's last report of the bus; None before the first one
    samples: int = 0
    incomplete: int = 0  # samples in which a reading was missing
    frames: int = 0


class RobotServer:
    """Carries out the calls that come through a pipe, and reports what has changed.

    A call is (number, name, arguments). It is answered by (number, result or exception), unless its number is
    None. Reports are (None, content): changed fields of `RobotStatus`, changed sessions, and frames. A report
    goes before each answer, so that whoever has called sees what the call has changed.
    """

    def __init__(self, connection: Connection, robot: RobotThread, changed: queue.Queue[str]) -> None:
        self._connection, self._robot, self._changed = connection, robot, changed
        self._lock, self._ended = threading.Lock(), threading.Event()
        self._reported: dict[str, Any] = {}
        self._lines: queue.Queue[str] | None = None
        self._reading = ExitStack()
        reservation = robot.reservation
        self._calls: dict[str, Callable[..., object]] = {
            "reserve": reservation.reserve,
            "release": reservation.release,
            "begin": reservation.begin,
            "stop": reservation.stop,
            "note_client": reservation.note_client,
            "reload": robot.reload,
            "forward_lines": self._forward_lines,
        }

    def serve(self) -> None:
        """Carry out calls until one of them is `close`, or until nobody holds the pipe's other end."""
        threading.Thread(target=self._report_regularly, name="reports", daemon=True).start()
        with suppress(EOFError, OSError):
            while (call := self._connection.recv())[1] != "close":
                if call[1] == "learned":  # takes its time; a stop must not wait for it
                    arguments = call[0], self._robot.observer.learned, ()
                    threading.Thread(target=self._answer, args=arguments, daemon=True).start()
                else:
                    self._answer(call[0], self._calls[call[1]], call[2])

    def close(self) -> None:
        """End the reports and the pipe."""
        self._ended.set()
        with self._lock:
            self._connection.close()

    def _answer(self, number: int | None, call: Callable[..., object], arguments: tuple[object, ...]) -> None:
        answer: object
        try:
            answer = call(*arguments)
        except Exception as error:  # noqa: BLE001  # raised again by whoever has called
            answer = error
        if number is not None:
            self._report((number, answer))

    def _report_regularly(self) -> None:
        with suppress(OSError):
            while not self._ended.wait(REPORT_PERIOD):
                self._report()

    def _report(self, answer: tuple[int, object] | None = None) -> None:
        """Report what has changed, and then answer a call."""
        with self._lock:
            status = self._status()
            changes = {
                name: value for name, value in status.items() if value is not self._reported.get(name, self)
            }
            self._reported = status
            lines = [] if self._lines is None else _drained(self._lines)
            self._connection.send((None, (changes, _drained(self._changed), lines)))
            if answer is not None:
                self._connection.send(answer)

    def _status(self) -> dict[str, Any]:
        """Return the fields of `RobotStatus`."""
        reservation, observer = self._robot.reservation, self._robot.observer
        return {
            "problem": reservation.problem, "session": reservation.session, "state": observer.state,
            "report": observer.report, "samples": observer.samples, "incomplete": observer.incomplete,
            "frames": self._robot.frame_feed.frames,
        }  # fmt: skip

    def _forward_lines(self, wanted: bool) -> None:
        """Begin or end to report every frame of the bus."""
        if wanted and self._lines is None:
            self._lines = self._reading.enter_context(self._robot.frame_feed.reader())
        elif not wanted:
            self._lines = None
            self._reading.close()


def _drained(items: queue.Queue[str]) -> list[str]:
    return [items.get_nowait() for _ in range(items.qsize())]


def serve_robot(connection: Connection, settings: Settings, vehicle: str) -> None:
    """Read and drive the robot until the pipe ends; then stop it."""
    changed: queue.Queue[str] = queue.Queue()
    database = Database(settings.database)
    recordings = RecordingStore(database, settings.fleets, settings.unpacked)
    reporter = SessionReporter(
        database, lambda _, session, __: changed.put(session), vehicle, settings.instance, recordings
    )
    with database.reading() as db:
        first = vehicles.parameters_of(vehicles.version(db, vehicle, 1))
    plant = simulated_plant(first) if settings.bus is None else None
    robot = RobotThread(settings.bus, plant, settings.pace, reporter, settings.flight_recorder)
    robot.start()
    server = RobotServer(connection, robot, changed)
    try:
        server.serve()
    finally:
        robot.close()
        database.close()
        server.close()


def run(connection: Connection, settings: Settings, vehicle: str, as_json: bool) -> None:
    """Be the robot's process. Its parent decides when it ends, not a signal to the whole service."""
    for ignored in (signal.SIGINT, signal.SIGTERM):
        signal.signal(ignored, signal.SIG_IGN)
    if as_json:
        log_as_json()
    sys.setswitchinterval(SWITCH_INTERVAL)
    gc.set_threshold(*GC_THRESHOLDS)
    serve_robot(connection, settings, vehicle)
