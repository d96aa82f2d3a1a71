"""The robot's process and the one that answers REST: what each does when the other is killed."""

import multiprocessing
import os
import signal
import threading
from pathlib import Path

import httpx2
import pytest

from omnimate.service.errors import StateError, UnavailableError
from omnimate.service.event_stream import EventStream
from omnimate.service.robot import connection, reservation, robot_process
from omnimate.service.robot.reservation import DriveOrder
from omnimate.service.robot.robot_process import RobotProcess
from omnimate.service.robot.robot_server import serve_robot
from omnimate.service.settings import Settings
from omnimate.service.store.database import Database
from omnimate.service.store.tables import SessionRow
from omnimate.service.umbmark.models import SessionStart
from omnimate.service.umbmark.sessions import start_session, take_lease
from omnimate.vcan_sim.coupled_bus import CoupledBus
from omnimate.vcan_sim.nodes.drive import DriveDevice
from tests.service.conftest import LONG_DRIVE, SESSIONS, ZIP, away, drive_zip, serving, until

service_process = pytest.importorskip("studies.speed.service_process")


@pytest.fixture
def driving(tmp_path):
    """A service in processes of its own, whose robot drives, with a client and the session's id."""
    if not Path("/proc/self/task").exists():
        pytest.skip("/proc lists the processes of a service, and is not on this machine")
    with (
        service_process.serving(tmp_path, f"sqlite:///{tmp_path}/service.db") as service,
        httpx2.Client(base_url=service.url, timeout=60.0) as client,
    ):
        session = client.post(SESSIONS, json=LONG_DRIVE).json()["id"]
        until(lambda: any(client.get("/v1/robot").json()["state"]["wheels"]))
        yield service, client, session


def children(process):
    """Return the ids of the processes that a process has started."""
    texts = [path.read_text() for path in Path(f"/proc/{process}/task").glob("*/children")]
    return [int(number) for text in texts for number in text.split()]


def fork_server(process):
    """Return the id of the process of which a service's processes are copies."""
    (server,) = (
        one for one in children(process) if b"forkserver" in Path(f"/proc/{one}/cmdline").read_bytes()
    )
    return server


def robots(process):
    """Return the ids of the robot's processes of a service that has no jobs."""
    return children(fork_server(process))


def runs(process):
    """Return whether a process has not ended; one that nobody has waited for is a zombie."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False


def test_a_killed_service_leaves_no_process_and_its_session_is_interrupted(driving, tmp_path):
    service, _, session = driving
    (robot,) = robots(service.process.pid)
    service.kill()
    until(lambda: not runs(robot))
    database = Database(f"sqlite:///{tmp_path}/service.db")
    with database.reading() as db:
        row = db.get(SessionRow, session)
        assert (row.state, row.detail) == ("interrupted", "interrupted: the service was stopped")
    database.close()


def test_a_killed_robot_process_interrupts_its_session_and_is_started_again(driving):
    service, client, session = driving
    (robot,) = robots(service.process.pid)
    os.kill(robot, signal.SIGKILL)
    until(lambda: client.get("/v1/robot").json()["problem"] is not None)
    answer = client.get("/readyz")
    assert (answer.status_code, "robot's process has ended" in answer.json()["detail"]) == (503, True)
    assert client.post(f"{SESSIONS}/{session}/resume").status_code in {409, 503}
    assert client.get("/v1/robot").json()["driving"] is None
    assert client.post("/v1/robot/stop").status_code == 200
    until(lambda: client.get(f"{SESSIONS}/{session}").json()["state"] == "interrupted")
    assert "robot's process has ended" in client.get(f"{SESSIONS}/{session}").json()["detail"]
    until(lambda: client.get("/readyz").status_code == 200)
    (another,) = robots(service.process.pid)
    assert another != robot
    assert client.post(f"{SESSIONS}/{session}/resume").json()["state"] == "driving"


def test_the_robot_drives_on_and_recordings_are_read_where_the_fork_server_was_killed(driving):
    service, client, session = driving
    (robot,) = robots(service.process.pid)
    os.kill(fork_server(service.process.pid), signal.SIGKILL)
    assert client.post("/v1/recordings", content=drive_zip(4.0), headers=ZIP).status_code == 201
    assert (runs(robot), client.get(f"{SESSIONS}/{session}").json()["state"]) == (True, "driving")
    assert client.post("/v1/robot/stop").status_code == 200
    until(lambda: client.get(f"{SESSIONS}/{session}").json()["state"] == "interrupted")


@pytest.fixture
def drives(monkeypatch):
    """The drives of the simulated robot, once its bus is open."""
    opened = []

    class Bus(CoupledBus):
        def __init__(self, *arguments):
            super().__init__(*arguments)
            opened.extend(one for one in self.simulated.devices.values() if isinstance(one, DriveDevice))

    monkeypatch.setattr(connection, "CoupledBus", Bus)
    return opened


def commanded(drives):
    return any(drive.objects[0x60FF, 0] for drive in drives)


def test_a_pipe_that_ends_stops_the_wheels(database, drives, tmp_path):
    """As kill -9 of the process that answers REST does."""
    with database.writing() as db:
        row = start_session(db, SessionStart(side=50.0, runs=50, how="drive"), "omnimate", 1e6)
        take_lease(row, "this")
        order = DriveOrder(row.id, row.side, row.speed, None)
    settings = Settings(database=str(database.engine.url), fleets=str(tmp_path), pace=100.0, instance="this")
    ours, theirs = multiprocessing.Pipe()
    robot = threading.Thread(target=serve_robot, args=(theirs, settings, "omnimate"))
    robot.start()

    def answer(*call):
        ours.send((1, *call))
        while (received := ours.recv())[0] is None:
            pass
        return received[1]

    until(lambda: not isinstance(answer("reserve", (order.session,)), UnavailableError))
    assert isinstance(answer("reserve", ("another",)), StateError)
    assert answer("begin", (order,))
    until(lambda: commanded(drives))
    ours.close()
    robot.join()
    assert not commanded(drives)


def test_a_stop_reaches_the_robot_while_the_database_is_away(drives, tmp_path, monkeypatch):
    monkeypatch.setattr(reservation, "LEASE", 1e9)  # no lease that ends stops it
    with serving(f"sqlite:///{tmp_path}/service.db") as client:
        client.post(SESSIONS, json=LONG_DRIVE)
        until(lambda: commanded(drives))
        with monkeypatch.context() as patch:
            patch.setattr(Database, "reading", away)
            patch.setattr(Database, "writing", away)
            assert client.post("/v1/robot/stop").status_code == 200
            until(lambda: client.components.robot.status.session is None)
            assert not commanded(drives)
        until(lambda: client.get("/readyz").status_code == 200)


class Hanging:
    """A process that does nothing until it is killed."""

    exitcode = -9

    def __init__(self, connection, *_arguments):
        self.connection = connection

    def kill(self):
        self.connection.close()

    def join(self):
        """It has ended."""


def test_a_process_that_does_not_report_is_killed_and_its_calls_are_refused(monkeypatch):
    monkeypatch.setattr(robot_process, "HANG_TIMEOUT", 0.01)
    monkeypatch.setattr(robot_process, "CALL_TIMEOUT", 0.01)
    monkeypatch.setattr(robot_process._log, "disabled", True)
    robot = RobotProcess(Settings(), "omnimate", EventStream(), None, Hanging)
    robot.start()
    until(lambda: "did not report" in robot.status.problem)
    with pytest.raises(UnavailableError, match="robot"):
        robot.reservation.reserve("first")
    assert not robot.reservation.begin(DriveOrder("first", 1.0, 0.1, None))
    robot.close()
