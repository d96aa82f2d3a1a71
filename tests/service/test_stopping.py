"""After a stop no wheel turns until somebody starts again, and the session says so, whatever happens when.

The service's own thread drives the robot, and the clients are the test's thread. One of the two runs at a
time, and time is counted in samples, so that each interleaving repeats exactly.
"""

import asyncio
from concurrent.futures import Executor, Future
from contextlib import contextmanager
from threading import Semaphore
from types import SimpleNamespace

import can
import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule, run_state_machine_as_test
from sqlalchemy import select
from sqlalchemy.exc import OperationalError

from omnimate.service.access import Caller
from omnimate.service.calls import Call
from omnimate.service.errors import ServiceError
from omnimate.service.event_stream import EventStream
from omnimate.service.robot import connection, observer, reservation, robot_thread
from omnimate.service.robot.robot_thread import RobotThread
from omnimate.service.robot.session_reporter import SessionReporter
from omnimate.service.routes import robot as robot_routes
from omnimate.service.routes import umbmark_sessions as routes
from omnimate.service.store.database import Database
from omnimate.service.store.recordings import RecordingStore
from omnimate.service.store.tables import SessionRow
from omnimate.service.umbmark import sessions
from omnimate.service.umbmark.models import SessionStart
from omnimate.service.umbmark.sessions import LEASE, end_lease, interrupt_orphans
from omnimate.vcan_sim.coupled_bus import CoupledBus
from omnimate.vcan_sim.faults import EmergencyMessage, Reboot, Silence
from omnimate.vcan_sim.nodes.device import SYNC_ID
from omnimate.vcan_sim.nodes.drive import DriveDevice
from omnimate.vcan_sim.reference import reference_vehicle
from tests.service.conftest import away, with_reference_robot

SYNC_PERIOD = reference_vehicle().bus.sync_period
COMMAND_SAMPLES = 1  # after a stop, in which a wheel may still be commanded to turn
WHEEL_SAMPLES = 30  # in which it may still turn: the ramp (6084h) from 0.4 m/s takes 0.4 s
REPORT_SAMPLES = 5  # after which a session that has begun says that it was stopped
RECOVERY_SAMPLES = 150  # after which a robot whose nodes were away can drive again
START_SAMPLES = 200  # after which the first wheel turns: the robot stands for its fix before
LIFELINE = 30.0  # [s]
PATIENCE = 120.0  # [s] that a slow machine may take
FAULTS = (
    EmergencyMessage(node=12, duration=0.1),
    Reboot(node=12),
    Reboot(node=1),
    Silence(node=2, duration=1.0),
)


class Later(Future):
    """The result of a call, which the thread that waits for it makes one sample later."""

    def __init__(self, call, arguments):
        super().__init__()
        self._polls, self._call, self._arguments = 0, call, arguments

    def done(self):
        self._polls += 1
        if self._polls == 2:
            try:
                self.set_result(self._call(*self._arguments))
            except Exception as error:  # noqa: BLE001  # as an executor does
                self.set_exception(error)
        return self._polls > 2


class LaterExecutor(Executor):
    """Makes calls in the thread that waits for them."""

    def __init__(self, *_options):
        """Take the options of a pool of threads."""

    def submit(self, call, /, *arguments):
        return Later(call, arguments)


class RefusingDatabase(Database):
    """A database that may refuse everything."""

    refuses = False

    @contextmanager
    def reading(self):
        self._require_answer()
        with super().reading() as db:
            yield db

    @contextmanager
    def writing(self):
        self._require_answer()
        with super().writing() as db:
            yield db

    def _require_answer(self):
        if self.refuses:
            away()


class Reporter(SessionReporter):
    """Lets clients call before the robot is connected, and before a session is interrupted."""

    pause = None

    def vehicle(self):
        self.pause()
        return super().vehicle()

    def interrupted(self, session, reason):
        self.pause()
        super().interrupted(session, reason)


class SteppedRobot:
    """The service's robot, which goes on for as many samples as a test asks for.

    Attributes:
        now: The host's time [s].
        samples: The number of samples so far.
        turned_at: The number of the last sample in which a wheel turned.
        stopped_at: The number of the sample at which it was stopped; None where it may drive.
    """

    def __init__(self, database, place, patch):
        self.now, self.samples, self.turned_at, self.stopped_at = 1000.0, 0, 0, None
        self._left, self._fails, self._bus = 0, None, None
        self._violation = None
        self._goes, self._waits = Semaphore(0), Semaphore(0)
        host = SimpleNamespace(monotonic=lambda: self.now, time=lambda: self.now)
        for module in (reservation, sessions):
            patch.setattr(module, "time", host)
        outer = self

        class Bus(CoupledBus):
            def send(self, msg, timeout=None):
                if msg.arbitration_id == SYNC_ID:
                    outer._sync(self)
                super().send(msg, timeout)

        patch.setattr(connection, "CoupledBus", Bus)
        self.events = EventStream()
        self.recordings = RecordingStore(database, place, 10**9)
        self.reporter = Reporter(database, self.events.announce, "omnimate", "this", self.recordings)
        self.reporter.pause = self._pause
        plant = connection.simulated_plant(reference_vehicle())
        self.thread = RobotThread(None, plant, 1.0, self.reporter)
        self._has_ended = False
        self.thread._thread._target = self._run
        self.thread.start()
        assert self._waits.acquire(timeout=PATIENCE)

    def _run(self):
        try:
            self.thread._run()
        finally:
            self._has_ended = True
            self._waits.release()

    def advance(self, samples):
        """Let the robot go on."""
        self._left = samples
        self._goes.release()
        assert not self._has_ended
        assert self._waits.acquire(timeout=PATIENCE)
        assert not self._has_ended, "the robot's thread has ended"
        assert self._violation is None, self._violation

    def fail(self, error):
        """Let an error of a class happen in the robot's thread, at its next SYNC."""
        self._fails = error

    def inject(self, fault):
        self._bus.simulated.inject(fault)

    def close(self):
        self._left = float("inf")
        self._goes.release()
        self.thread.close()

    def _drives(self):
        return [device for device in self._bus.simulated.devices.values() if isinstance(device, DriveDevice)]

    def _sync(self, bus):
        self._bus = bus
        self.samples += 1
        self.now += SYNC_PERIOD
        if any(drive.velocity for drive in self._drives()):
            self.turned_at = self.samples
        if self.stopped_at is not None and self._violation is None:
            self._check(self.samples - self.stopped_at)
        self._pause()
        error, self._fails = self._fails, None
        if error is not None:
            raise error("the robot's thread fails")

    def _check(self, samples):
        if samples > COMMAND_SAMPLES and any(drive.objects[0x60FF, 0] for drive in self._drives()):
            self._violation = f"a wheel is commanded to turn {samples} samples after the stop"
        if samples > WHEEL_SAMPLES and self.turned_at == self.samples:
            self._violation = f"a wheel turns {samples} samples after the stop"

    def _pause(self):
        self._left -= 1
        if self._left <= 0:
            self._waits.release()
            self._goes.acquire()


AT_RESERVE = st.sampled_from(["", "", "stop"])
STEPS = st.just([]) | st.lists(st.sampled_from([1, 3, "stop", "fail"]), max_size=2)


class Stopping(RuleBasedStateMachine):
    """A robot that drives for sessions, its clients, and what fails."""

    database = place = None

    @initialize(samples=st.sampled_from([1, 145, 300, 1500]), at_reserve=AT_RESERVE, before_begin=STEPS)
    def begin(self, samples, at_reserve, before_begin):
        self.patch = pytest.MonkeyPatch()
        self.patch.setattr(connection.PacedClock, "due", lambda _clock: 0.0)
        self.patch.setattr(observer, "LOADING_SAMPLES", -1)  # plain odometry only
        self.patch.setattr(robot_thread, "ThreadPoolExecutor", LaterExecutor)
        self.patch.setattr(robot_thread._log, "disabled", True)
        self.patch.setattr(robot_thread, "RENEW_PERIOD", PATIENCE)
        self.patch.setattr(robot_thread, "RETRY_PERIOD", 0.0)
        self.robot = SteppedRobot(self.database, self.place, self.patch)
        self.reservation = self.robot.thread.reservation
        components = SimpleNamespace(
            robot=self.robot.thread,
            reporter=SessionReporter(
                self.database, self.robot.events.announce, "omnimate", "this", self.robot.recordings
            ),
            database=self.database,
            vehicle="omnimate",
            settings=SimpleNamespace(instance="this", lifetime=1e9),
        )
        self.call = Call(components, Caller("owner", "operate"), None, "")
        self.reader = Call(components, Caller("another", "read"), None, "")
        self.session, self.is_reported, self.begun_at = None, True, 0
        self.robot.advance(2)  # it is connected
        self.start(at_reserve, before_begin)
        assert self.session is not None
        self.robot.advance(samples)

    def calls(self, route, *arguments):
        """Make a call; return whether it was carried out."""
        try:
            route(*arguments, self.call)
        except (ServiceError, OperationalError):
            return False
        return True

    def drive(self, route, argument, at_reserve, before_begin):
        """Start or resume; a stop may come after the reservation, samples or a stop before the beginning."""
        may_drive = self.robot.stopped_at
        reserve, begin = self.reservation.reserve, self.reservation.begin
        stopped = []

        def reserve_and_stop(session):
            reserve(session)
            self.session, self.robot.stopped_at = session, None
            if at_reserve == "stop":
                stopped.append(self.stop())

        def wait_and_begin(order):
            for step in before_begin:
                if step == "stop":
                    stopped.append(self.stop())
                elif step == "fail":
                    self.robot.fail(RuntimeError)
                else:
                    self.robot.advance(step)
            self.begun_at = self.robot.samples
            return begin(order)

        self.reservation.reserve, self.reservation.begin = reserve_and_stop, wait_and_begin
        try:
            done = self.calls(route, argument)
        finally:
            self.reservation.reserve, self.reservation.begin = reserve, begin
        if not done and self.robot.stopped_at is None and not stopped:
            self.robot.stopped_at = may_drive

    @rule(at_reserve=AT_RESERVE, before_begin=STEPS)
    def start(self, at_reserve, before_begin):
        if self.session is not None:
            self.stop()
            self.robot.advance(REPORT_SAMPLES)
        request = SessionStart(side=0.2, runs=1, how="drive", lifeline=LIFELINE)
        self.drive(routes.start_session, request, at_reserve, before_begin)

    @rule(before_begin=STEPS)
    def resume(self, before_begin):
        if self.session is not None:
            self.drive(routes.resume_session, self.session, "", before_begin)

    @rule(samples=st.sampled_from([1, 2, 3, 50, 145, 300]))
    def samples_pass(self, samples):
        self.robot.advance(samples)
        self.robot.thread.renew_lease()

    @rule()
    def stop(self):
        asyncio.run(robot_routes.stop_robot(self.reader))
        self.stopped()

    @rule()
    def abort(self):
        if self.session is not None and self.calls(routes.abort_session, self.session):
            self.stopped()

    @rule()
    def presence_runs_out(self):
        for _ in range(4):
            self.robot.now += LIFELINE / 4.0 + 0.1
            self.robot.thread.renew_lease()
        self.stopped()

    @rule()
    def its_lease_ends(self):
        self.robot.now += LEASE + 1.0
        self.stopped()

    @rule()
    def another_service_interrupts_it(self):
        if not self.database.refuses:
            with self.database.writing() as db:
                row = db.get(SessionRow, self.session)
                if row is not None and row.state == "driving":
                    end_lease(row, "interrupted", "by another service")
                    self.stopped()
            self.robot.thread.renew_lease()

    @rule(refuses=st.booleans())
    def the_database_refuses(self, refuses):
        self.database.refuses = refuses
        self.is_reported &= not refuses

    @rule(error=st.sampled_from([RuntimeError, can.CanOperationError]))
    def the_robot_thread_fails(self, error):
        self.robot.fail(error)
        if error is RuntimeError:  # a frame that could not be sent once is sent again
            self.stopped()

    @rule(fault=st.sampled_from(FAULTS))
    def a_node_fails(self, fault):
        self.robot.inject(fault)

    def stopped(self):
        if self.robot.stopped_at is None:
            self.robot.stopped_at = self.robot.samples
            self.is_reported = not self.database.refuses

    def state(self):
        with Database.reading(self.database) as db:
            return db.get(SessionRow, self.session).state

    @invariant()
    def a_stopped_session_says_so(self):
        stopped_at = self.robot.stopped_at
        if self.session is None or stopped_at is None or not self.is_reported:
            return
        if self.robot.samples - max(stopped_at, self.begun_at) > REPORT_SAMPLES:
            assert self.state() in {"interrupted", "aborted", "collecting"}

    def teardown(self):
        """Whatever has happened, the robot stands after a stop, and drives after the next start."""
        try:
            self.database.refuses = False
            self.stop()
            self.robot.advance(RECOVERY_SAMPLES)
            self.robot.now += LEASE + 1.0
            with self.database.writing() as db:
                interrupt_orphans(db)
                assert not list(db.scalars(select(SessionRow).where(SessionRow.state == "driving")))
            self.start("", [])
            started_at = self.robot.samples
            self.robot.advance(START_SAMPLES)
            assert self.robot.turned_at > started_at
        finally:
            self.robot.close()
            self.patch.undo()


@pytest.fixture
def refusing_database(tmp_path):
    """A database that holds the reference robot."""
    yield from with_reference_robot(RefusingDatabase(f"sqlite:///{tmp_path}/service.db"))


def test_after_a_stop_no_wheel_turns_and_the_session_says_so(refusing_database, tmp_path):
    Stopping.database, Stopping.place = refusing_database, str(tmp_path)
    run_state_machine_as_test(Stopping, settings=settings(max_examples=15, stateful_step_count=8))
