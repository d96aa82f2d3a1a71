"""The robot in a process of its own, as the process that answers REST sees it."""

from __future__ import annotations

import atexit
import itertools
import logging
import multiprocessing
import threading
from concurrent.futures import Future
from dataclasses import replace
from typing import TYPE_CHECKING, Any, cast

from omnimate.service.errors import UnavailableError
from omnimate.service.processes import process_context
from omnimate.service.request_log import logs_json
from omnimate.service.robot.frame_feed import FrameLines
from omnimate.service.robot.observer import nodes_event, state_event
from omnimate.service.robot.robot_server import RobotStatus, run

if TYPE_CHECKING:
    from collections.abc import Callable
    from multiprocessing.connection import Connection
    from multiprocessing.process import BaseProcess

    from omnimate.ipec.tracker import Learned
    from omnimate.service.event_stream import EventStream
    from omnimate.service.robot.reservation import DriveOrder
    from omnimate.service.robot.session_reporter import SessionReporter
    from omnimate.service.settings import Settings

CALL_TIMEOUT = 5.0  # [s] for an answer of the robot's process
HANG_TIMEOUT = 30.0  # [s] without a report after which the process hangs, and is killed
RESTART_PAUSE = 2.0  # [s] before the process is started again
CLOSING_TIME = 100.0  # [s] at most for the process to end: it may have to finish a compilation
_log = logging.getLogger(__name__)


def spawned(connection: Connection, settings: Settings, vehicle: str) -> BaseProcess:
    """Start the robot's process, which holds the only copy of its end of the pipe."""
    arguments = connection, settings, vehicle, logs_json()
    process = process_context().Process(target=run, args=arguments, name="robot")
    process.start()
    connection.close()
    return process


class RobotProcess:
    """The robot's process, started again when it ends; the methods may be called from any thread.

    It sends the frames of the bus, `lines`, while somebody reads them.
    """

    def __init__(
        self,
        settings: Settings,
        vehicle: str,
        events: EventStream,
        reporter: SessionReporter,
        start: Callable[[Connection, Settings, str], BaseProcess] = spawned,
    ) -> None:
        self.mode = "simulated" if settings.bus is None else "bus"
        self.status, self.lines, self.reservation = RobotStatus(), FrameLines(), RemoteReservation(self)
        self._settings, self._vehicle, self._events, self._reporter = settings, vehicle, events, reporter
        self._start = start
        self._process: BaseProcess | None = None
        self._connection: Connection | None = None
        self._lock = threading.Lock()  # of what is sent
        self._numbers = itertools.count()
        self._answers: dict[int, Future[Any]] = {}
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._run, name="robot's process", daemon=True)

    def start(self) -> None:
        """Start the process, and the thread that follows it."""
        atexit.register(self.close)
        self._thread.start()

    def close(self) -> None:
        """Stop the robot and end its process."""
        atexit.unregister(self.close)
        self._ending.set()
        self.send("close")
        if self._thread.is_alive():
            self._thread.join(CLOSING_TIME)
            if self._process is not None and self._thread.is_alive():
                self._process.kill()

    def reload(self) -> None:
        """Take the vehicle's newest parameters as soon as the robot does not drive."""
        self.send("reload")

    def learned(self) -> Learned | None:
        """Return what the tracker has learned, of which vehicle; None where it does not follow the robot."""
        return cast("Learned | None", self.call("learned"))

    def send(self, name: str, *arguments: object, number: int | None = None) -> bool:
        """Make a call whose answer nobody waits for; return whether there is a process.

        Calls are carried out in the order in which they were sent.
        """
        with self._lock:
            if self._connection is None:
                return False
            try:
                self._connection.send((number, name, arguments))
            except OSError:  # it has just ended
                return False
        return True

    def call(self, name: str, *arguments: object) -> Any:  # noqa: ANN401  # as the call returns
        """Make a call; return its answer, or raise its exception; UnavailableError without one in time."""
        number, answer = next(self._numbers), Future[Any]()
        self._answers[number] = answer
        try:
            if not self.send(name, *arguments, number=number):
                raise UnavailableError(f"the robot is not available: {self.status.problem}")
            return answer.result(CALL_TIMEOUT)
        except TimeoutError as error:
            raise UnavailableError(f"the robot's process did not answer within {CALL_TIMEOUT:g} s") from error
        finally:
            del self._answers[number]

    def _run(self) -> None:
        while not self._ending.is_set():
            try:
                problem = self._follow_process()
            except Exception as error:  # noqa: BLE001  # without this thread there is no robot any more
                _log.exception("the thread that follows the robot's process failed")
                problem = f"an error in the service itself: {error}"
            if not self._ending.is_set():
                self._lose_robot(problem)
                self._ending.wait(RESTART_PAUSE)

    def _follow_process(self) -> str:
        """Start the process and take its reports until it ends; return why it has ended."""
        ours, theirs = multiprocessing.Pipe()
        process = self._process = self._start(theirs, self._settings, self._vehicle)
        with self._lock:
            self._connection = ours
        if self._ending.is_set():
            self.send("close")
        problem = f"the robot's process did not report for {HANG_TIMEOUT:g} s, and was killed"
        try:
            while ours.poll(HANG_TIMEOUT):
                self._take(*ours.recv())
        except (EOFError, OSError):
            problem = "the robot's process has ended"
        finally:
            with self._lock:
                self._connection = None
            if not self._ending.is_set():
                process.kill()
            process.join()
            ours.close()
        return f"{problem} (exit code {process.exitcode})"

    def _take(self, number: int | None, content: Any) -> None:  # noqa: ANN401  # an answer or a report
        if number is None:
            self._take_report(*content)
        elif (answer := self._answers.get(number)) is not None:
            if isinstance(content, Exception):
                answer.set_exception(content)
            else:
                answer.set_result(content)

    def _take_report(self, changes: dict[str, Any], sessions: list[str], lines: list[str]) -> None:
        status = self.status = replace(self.status, **changes)
        if "state" in changes and status.state:
            self._events.publish("state", status.state)
        if "report" in changes and status.report is not None:
            self._events.publish("nodes", nodes_event(status.report))
        for session in sessions:
            self._reporter.announce(session)
        for line in lines:
            self.lines.put(line)
        if self._events.has_readers:  # whoever reads the stream is a client of the session
            self.send("note_client")
        if self.lines.has_readers or lines:
            self.send("forward_lines", self.lines.has_readers)

    def _lose_robot(self, problem: str) -> None:
        """Report that there is no robot, and that the session for which it drove is interrupted."""
        _log.error("%s; it is started again", problem)
        session = self.status.session
        event = state_event(self.mode, problem)
        self.status = RobotStatus(problem, state=event)
        for answer in tuple(self._answers.values()):
            if not answer.done():
                answer.set_exception(UnavailableError(f"the robot is not available: {problem}"))
        self._events.publish("state", event)
        if session is not None:
            try:
                self._reporter.interrupted(session, problem)
            except Exception:  # noqa: BLE001  # the database may be away; the session's lease ends then
                _log.exception("it was not noted that session %s is interrupted", session)


class RemoteReservation:
    """The reservation in the robot's process; the calls are those of `Reservation`."""

    def __init__(self, robot: RobotProcess) -> None:
        self._robot = robot

    def reserve(self, session: str) -> None:
        """Reserve the robot for a session."""
        try:
            self._robot.call("reserve", session)
        except UnavailableError:
            self.release(session)  # the answer may only be late
            raise

    def release(self, session: str) -> None:
        """Cancel the reservation of a session that has not begun."""
        self._robot.send("release", session)

    def begin(self, order: DriveOrder) -> bool:
        """Have the robot drive; return whether it does."""
        try:
            return bool(self._robot.call("begin", order))
        except UnavailableError as error:
            self.stop(str(error), order.session)  # the answer may only be late
            return False

    def stop(self, reason: str, session: str | None = None) -> None:
        """Stop the robot at the next sample; where its process has ended, its drives have stopped it."""
        self._robot.send("stop", reason, session)

    def note_client(self, session: str) -> None:
        """Note that a client asked for a session just now."""
        if session == self._robot.status.session:
            self._robot.send("note_client", session)
