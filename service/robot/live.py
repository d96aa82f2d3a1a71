"""The robot's thread: reads the bus for ever, drives squares when a session asks for it, stops when told."""

from __future__ import annotations

import contextlib
import logging
import tempfile
import threading
import time
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from driver.recorder import Recorder
from motion.drive import drive
from motion.journal import Journal
from motion.paths import squares
from motion.runner import Runner
from service.errors import AbsentError, StateError
from service.robot.follower import Follower
from service.robot.rig import Rig, opened
from service.robot.tap import Tap
from vehicle.errors import OmnimateError

if TYPE_CHECKING:
    from collections.abc import Callable

    from driver.report import DriverReport
    from service.hub import Hub
    from service.umbmark.models import Turn
    from vcan_sim.plant import Plant
    from vehicle.parameters import TruckName, VehicleParameters
    from vehicle.sample import Sample

T = TypeVar("T")
_log = logging.getLogger(__name__)
SHOWN, REPORTED, RENEWED, AGAIN = 0.1, 1.0, 2.0, 2.0  # [s] between two events, reports, leases, attempts


@dataclass(frozen=True, slots=True)
class Work:
    """A session that is to be driven.

    Attributes:
        session: its id.
        side: of the square [m].
        speed: of the wheels [m/s].
        lifeline: how long it goes on without anybody who asks for it [s]; None for ever.
    """

    session: str
    side: float
    speed: float
    lifeline: float | None


class Desk(Protocol):
    """Where the thread reports; each call is one transaction."""

    def vehicle(self) -> VehicleParameters:
        """Return the robot's newest parameters."""
        ...

    def next_turn(self, session: str) -> Turn | None:
        """Return which square comes next; None when all are driven or nobody wants them any more."""
        ...

    def lap_done(self, session: str, turn: Turn, folder: Path) -> None:
        """Keep what a lap's recording tells."""
        ...

    def finished(self, session: str) -> None:
        """Note that all squares are driven."""
        ...

    def interrupted(self, session: str, reason: str) -> None:
        """Note that driving has ended before its time."""
        ...

    def renew(self, session: str) -> None:
        """Say that this service still drives for the session."""
        ...


class StoppedError(OmnimateError):
    """Somebody stopped the robot, or nobody looks any more."""


class Live:
    """The robot, to everybody else; its methods may be called from any thread.

    Attributes:
        mode: simulated or bus.
        problem: why there are no samples, where there are none.
        driving: id of the session that is driven for; None when the robot stands.
        turn: of the square that is being driven.
        tap: of all frames.
    """

    def __init__(self, bus: str | None, plant: Plant | None, pace: float, hub: Hub, desk: Desk) -> None:
        self.mode = "simulated" if bus is None else "bus"
        self.problem: str | None = "starting"
        self.driving: str | None = None
        self.turn: Turn | None = None
        self.tap = Tap()
        self._bus, self._plant, self._pace, self._hub, self._desk = bus, plant, pace, hub, desk
        self._lock = threading.Lock()
        self._work: Work | None = None
        self._stop_reason: str | None = None
        self._ending, self._reloading = threading.Event(), threading.Event()
        self._report: DriverReport | None = None
        self._state: dict[str, Any] = {}
        self._follower: Follower | None = None
        self._before = 0, 0
        self._seen = self._shown = self._reported = 0.0
        self._aside = ThreadPoolExecutor(2, "desk")
        self._thread = threading.Thread(target=self._run, name="robot", daemon=True)
        self._keeper = threading.Thread(target=self._keep_lease, name="lease", daemon=True)

    # What others call

    def start(self) -> None:
        """Begin."""
        self._thread.start()
        self._keeper.start()

    def close(self) -> None:
        """Stop the robot and end the thread."""
        self.halt("the service was stopped")
        self._ending.set()
        if self._thread.is_alive():
            self._thread.join(10.0)
        self._aside.shutdown()

    def reserve(self, session: str) -> None:
        """Keep the robot for a session that is going to be driven; nothing moves yet.

        Raises:
            AbsentError: there is no robot.
            StateError: it drives for another session.
        """
        with self._lock:
            if self.problem is not None:
                raise AbsentError(f"the robot is not there: {self.problem}")
            if self.driving is not None:
                raise StateError(f"the robot drives for session {self.driving}; abort it, or wait for it")
            self.driving, self._stop_reason = session, None

    def release(self, session: str) -> None:
        """Give the robot back that was reserved."""
        with self._lock:
            if self.driving == session and self._work is None:
                self.driving = None

    def begin(self, work: Work) -> None:
        """Drive for the session that the robot is reserved for."""
        with self._lock:
            self._seen = time.monotonic()
            if self.driving == work.session:
                self._work = work

    def halt(self, reason: str) -> None:
        """Stop the wheels at the next sample; a session that is driven is interrupted."""
        with self._lock:
            self._stop_reason = reason
            if self._work is None:  # reserved, and not to begin any more
                self.driving = None

    def seen(self, session: str | None = None) -> None:
        """Note that a client is still there."""
        if session is None or session == self.driving:
            self._seen = time.monotonic()

    def reload(self) -> None:
        """Take the robot's newest parameters as soon as it does not drive."""
        self._reloading.set()

    @property
    def report(self) -> DriverReport | None:
        """What the driver says of the bus; None before its first word."""
        return self._report

    @property
    def state(self) -> dict[str, Any]:
        """The last `state` event."""
        return self._state

    @property
    def samples(self) -> tuple[int, int]:
        """Samples of the bus so far, and those of them in which something was missing."""
        own = self._follower
        whole, broken = self._before
        return (whole, broken) if own is None else (whole + own.samples, broken + own.incomplete)

    # The threads

    def _keep_lease(self) -> None:
        """Say every few seconds that this process lives, whatever the robot's thread is busy with."""
        while not self._ending.wait(RENEWED):
            session = self.driving
            if session is not None:
                try:
                    self._desk.renew(session)
                except Exception:  # noqa: BLE001  # another service may take the session; this one must go on
                    _log.exception("the lease of session %s was not renewed", session)

    def _run(self) -> None:
        while not self._ending.is_set():
            try:
                self._reloading.clear()
                with opened(self._desk.vehicle(), self._bus, self._plant, self.tap) as rig:
                    self._serve(rig)
            except OmnimateError as error:
                self._lost(str(error))
            except Exception as error:  # noqa: BLE001  # without this thread nobody could stop the robot
                _log.exception("the robot's thread failed")
                self._lost(f"an error of ours: {error}")

    def _lost(self, problem: str) -> None:
        """Say that there is no robot, and wait before the next attempt."""
        self.problem = problem
        with self._lock:
            session, self.driving, self._work = self.driving, None, None
        if session is not None:
            self._desk.interrupted(session, problem)
        self._hub.publish("state", {**self._look(None), "problem": problem})
        self._ending.wait(AGAIN)

    def _serve(self, rig: Rig) -> None:
        self._before, self._follower = self.samples, Follower(rig.driver.vehicle)
        self.problem = None
        while not (self._ending.is_set() or self._reloading.is_set()):
            self._observe(rig, rig.driver.cycle())
            if self._stop_reason is not None:
                rig.driver.stop()
                self._stop_reason = None
            if self._work is not None:
                self._drive(rig, self._work)

    def _observe(self, rig: Rig, sample: Sample) -> None:
        assert self._follower is not None
        self._follower.step(sample)
        now = time.monotonic()
        if now - self._shown >= SHOWN:
            self._shown = now
            self._state = self._look(sample.time, rig.driver.drives.speeds)
            self._hub.publish("state", self._state)
        if now - self._reported >= REPORTED:
            self._reported = now
            self._report = rig.driver.report()
            self._hub.publish("nodes", nodes_event(self._report))

    def _look(self, at: float | None, wheels: tuple[float, ...] = ()) -> dict[str, Any]:
        own = self._follower
        known = {} if own is None else own.look()
        return {
            "time": at, "mode": self.mode, "problem": self.problem, "driving": self.driving,
            "lap": self.turn, "wheels": list(wheels), **known,
        }  # fmt: skip

    def _drive(self, rig: Rig, work: Work) -> None:
        """Drive the squares that a session still wants."""
        driver = rig.driver
        try:
            driver.enable()
            rig.pace(self._pace)
            while (turn := self._while_reading(rig, self._desk.next_turn, work.session)) is not None:
                self.turn = turn
                self._lap(rig, work, turn)
                if rig.fix is None:
                    break  # a person measures where it stands
            else:
                self._while_reading(rig, self._desk.finished, work.session)
        except OmnimateError as error:
            with contextlib.suppress(OmnimateError):  # a bus that is lost cannot be told to stop
                driver.stop()
            self._desk.interrupted(work.session, str(error))
        finally:
            with self._lock:
                self.driving = self._work = self.turn = self._stop_reason = None
            rig.pace(1.0)
            driver.drives.disable()

    def _lap(self, rig: Rig, work: Work, turn: Turn) -> None:
        """Drive one square, recorded."""
        vehicle = rig.driver.vehicle
        link = vehicle.linkage.length if vehicle.linkage is not None else None
        program = squares(
            [turn], work.side, speed=work.speed, link_length=link, home_first=rig.fix is not None
        )
        runner = self._while_reading(rig, Runner, program, vehicle)  # it may have to compile
        journal = Journal(program)
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place) / "lap"
            with Recorder(folder, vehicle, protocol=program.protocol, side=program.side) as recorder:
                self.tap.recorder = recorder
                try:
                    for moment in drive(rig.driver, runner, vehicle, journal, rig.fix):
                        self._observe(rig, moment.sample)
                        self._check(work)
                finally:
                    self.tap.recorder = None
                    rig.driver.stop()
                keep(journal, recorder)
            self._while_reading(rig, self._desk.lap_done, work.session, turn, folder)

    def _check(self, work: Work) -> None:
        """Go on only while somebody wants it.

        Raises:
            StoppedError: nobody does.
        """
        if self._stop_reason is not None:
            raise StoppedError(self._stop_reason)
        if self._hub.listeners:
            self.seen()
        if work.lifeline is not None and time.monotonic() - self._seen > work.lifeline:
            raise StoppedError(
                f"no client asked for the session for {work.lifeline:g} s; the robot was stopped"
            )

    def _while_reading(self, rig: Rig, call: Callable[..., T], *arguments: object) -> T:
        """Call the desk in another thread and read the bus meanwhile; no sample is lost to a slow disk."""
        future: Future[T] = self._aside.submit(call, *arguments)
        while not future.done():
            self._observe(rig, rig.driver.cycle())
        return future.result()


def keep(journal: Journal, recorder: Recorder) -> None:
    """Hand the laps and fixes of a drive to its recording."""
    for lap in journal.run.laps:
        recorder.lap(lap.direction, lap.start, lap.end)
    poses = journal.poses
    if poses is not None:
        for row in range(len(poses.time)):
            truck: TruckName = "a" if poses.body[row] == "a" else "b"
            recorder.pose(float(poses.time[row]), truck, poses.pose[row].tolist(), poses.sigma[row].tolist())


def nodes_event(report: DriverReport) -> dict[str, Any]:
    """Return the stream's `nodes` event."""
    return {
        "nodes": [
            {
                "node": one.node, "names": list(one.names), "state": one.state, "received": one.received,
                "missing": one.missing, "restarts": one.restarts, "emergencies": one.emergencies,
                "ok": one.is_well,
            }
            for one in report.nodes
        ]
    }  # fmt: skip
