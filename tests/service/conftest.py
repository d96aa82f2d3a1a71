"""A service in this process, its robot too, on both databases."""

import math
import secrets
import threading
import time
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
import sqlalchemy
from alembic import command
from alembic.config import Config
from fastapi.testclient import TestClient
from sqlalchemy.exc import OperationalError

from omnimate.calib.umbmark.exact import square_returns
from omnimate.files.recordings.folder import save_recording
from omnimate.files.recordings.zipped import pack
from omnimate.fleet.hall.hall import draw_hall, write_store
from omnimate.ipec.tracker import track_recording
from omnimate.motion.paths import out_and_back, rounded_rectangle, umbmark
from omnimate.service.app import create_app
from omnimate.service.components import Components
from omnimate.service.robot.robot_server import serve_robot
from omnimate.service.settings import Settings
from omnimate.service.store import vehicles
from omnimate.service.store.database import MIGRATIONS, Database
from omnimate.service.store.tables import RecordingRow
from omnimate.vcan_sim.biases import linkage_biases
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth, uncalibrated
from omnimate.vehicle.parameters import Truck
from tests.service.zips import zipped

SERVER = "postgresql+psycopg://postgres@127.0.0.1:5432/postgres"
NOMINAL = reference_vehicle().trucks["a"]
# The robot as it is, where runs are measured by hand.
TRUE = Truck(wheelbase=0.336, wheel_diameter_left=0.1499, wheel_diameter_right=0.1501)
SESSIONS = "/v1/umbmark/sessions"
ZIP = {"Content-Type": "application/zip"}
LONG_DRIVE = {"how": "drive", "side": 50.0, "runs": 50, "lifeline": None}  # lasts until it is stopped
PATIENCE = 120.0  # [s] that a slow machine may take


@pytest.fixture(scope="session")
def small_recording():
    """A recording of a square of 0.2 m each way."""
    vehicle = reference_vehicle()
    program = umbmark(0.2, 1, speed=0.4, link_length=vehicle.linkage.length)
    return simulate(vehicle, Truth(vehicle, seed=1), program)


@pytest.fixture(scope="session")
def recording_folder(small_recording, tmp_path_factory):
    """The folder of that recording."""
    folder = tmp_path_factory.mktemp("small") / "recording"
    save_recording(small_recording, folder)
    return folder


@pytest.fixture(scope="session")
def recording_files(recording_folder):
    """The files of that recording by their names."""
    return {path.name: path.read_bytes() for path in recording_folder.iterdir()}


@pytest.fixture(scope="session", autouse=True)
def _tracker_is_compiled(small_recording):
    """Compile the tracker first; a service compiles it in a thread, which changes all warning filters."""
    track_recording(small_recording, every=1.0)


@pytest.fixture(scope="session")
def postgresql():
    """A database of its own on the PostgreSQL server of this machine; skipped where there is none."""
    server = sqlalchemy.create_engine(SERVER, isolation_level="AUTOCOMMIT")
    name = f"omnimate_{secrets.token_hex(4)}"
    try:
        with server.connect() as connection:
            connection.execute(sqlalchemy.text(f"create database {name}"))
    except OperationalError:
        pytest.skip(f"no PostgreSQL answers at {SERVER}")
    yield SERVER.removesuffix("postgres") + name
    with server.connect() as connection:
        connection.execute(sqlalchemy.text(f"drop database {name} with (force)"))
    server.dispose()


@pytest.fixture(scope="module", params=["sqlite", "postgresql"])
def database_url(request, tmp_path_factory):
    """A new database of each kind."""
    if request.param == "sqlite":
        return f"sqlite:///{tmp_path_factory.mktemp('store')}/service.db"
    return request.getfixturevalue("postgresql_url")


@pytest.fixture(scope="module")
def postgresql_url(postgresql):
    """The PostgreSQL database, without tables."""
    engine = sqlalchemy.create_engine(postgresql)
    with engine.begin() as connection:
        connection.execute(sqlalchemy.text("drop schema public cascade; create schema public"))
    engine.dispose()
    return postgresql


@pytest.fixture(scope="module")
def database(tmp_path_factory):
    """A new SQLite database that holds the reference robot, without a service."""
    yield from with_reference_robot(Database(f"sqlite:///{tmp_path_factory.mktemp('database')}/service.db"))


def with_reference_robot(database):
    """Yield a database after the reference robot was added, and close it."""
    with database.writing() as db:
        vehicles.create(db, reference_vehicle(), vehicles.Origin("test"))
    yield database
    database.close()


def migrate(connection, revision):
    """Make the tables of an earlier version, or bring them up to it."""
    config = Config()
    config.set_main_option("script_location", str(MIGRATIONS))
    config.attributes["connection"] = connection
    command.upgrade(config, revision)


def recording_row():
    """Return the row of a recording without a file."""
    return RecordingRow(
        id="rec", name="rec", vehicle="omnimate", samples=1, seconds=1.0, laps=0, poses=0, size=1,
        created=0.0,
    )  # fmt: skip


def away(*_arguments, **_options):
    """Take the place of what asks the database while that is away."""
    raise OperationalError("", {}, OSError("the database is away"))


class RobotInThread(threading.Thread):
    """Takes the place of the robot's process, so that tests reach into it; the pipe is the same."""

    exitcode = 0

    def __init__(self, connection, *arguments):
        super().__init__(target=serve_robot, args=(connection, *arguments), daemon=True)
        self.start()

    def kill(self):
        """Nothing ends a thread."""


@contextmanager
def serving(url, **options):
    """A client of a service, started and stopped with the block."""
    with TemporaryDirectory() as fleets:
        options = {"fleets": fleets} | options
        components = Components(Settings(database=url, pace=1000.0, rate=1e6, **options), RobotInThread)
        yield from connected(components)


def connected(components):
    with TestClient(create_app(components), base_url="http://127.0.0.1") as client:
        client.components = components
        until(lambda: client.get("/readyz").status_code == 200)
        yield client


@pytest.fixture(scope="session")
def url(tmp_path_factory):
    """The address of a service in a process of its own."""
    service_process = pytest.importorskip("studies.speed.service_process")
    folder = tmp_path_factory.mktemp("live")
    with service_process.serving(folder, f"sqlite:///{folder}/service.db", "--pace", "1000") as service:
        yield service.url


@pytest.fixture(scope="module")
def service(database_url):
    """A client of a service on each database."""
    with serving(database_url) as client:
        yield client


@pytest.fixture(scope="module")
def client(tmp_path_factory):
    """A client of a service on SQLite."""
    with serving(f"sqlite:///{tmp_path_factory.mktemp('store')}/service.db") as connected:
        yield connected


def until(true, pause=0.02):
    """Wait for a condition that some thread brings about."""
    end = time.monotonic() + PATIENCE
    while not (result := true()):
        assert time.monotonic() < end, "the condition did not come true"
        time.sleep(pause)
    return result


def zip_of(recording):
    """Return a recording as the zip of its folder."""
    with TemporaryDirectory() as place:
        folder = Path(place) / "drive"
        save_recording(recording, folder)
        return pack(folder)


@cache
def drive_zip(side):
    """Simulate a square of a side each way; return its recording as a zip."""
    vehicle = reference_vehicle()
    program = umbmark(side, 1, speed=0.4, link_length=vehicle.linkage.length)
    return zip_of(simulate(vehicle, Truth(uncalibrated(vehicle), seed=3), program))


@cache
def short_zip(length):
    """Simulate a drive out and back, too short to diagnose anything; return its recording as a zip."""
    vehicle = reference_vehicle()
    return zip_of(simulate(vehicle, Truth(vehicle, seed=3), out_and_back(length, 1)))


@cache
def biased_zip():
    """Simulate a drive whose joint_a reads half a degree too much; return its recording as a zip."""
    vehicle = reference_vehicle()
    truth = Truth(vehicle, effects=linkage_biases(joint_a=math.radians(0.5)), seed=3)
    return zip_of(simulate(vehicle, truth, rounded_rectangle(6.0, 3.25, ["ccw", "cw"])))


@cache
def day_zip():
    """Simulate a day's recordings of two robots; return them as a zip."""
    with TemporaryDirectory() as place:
        hall = draw_hall(2, 2, faulty=0, places=0, sync_period=0.04)
        write_store(hall, Path(place), range(1), 1, 1.0)
        files = Path(place).glob("robot=*/*/*/*")
        return zipped({str(path.relative_to(place)): path.read_bytes() for path in files})


def uploaded(client, content):
    """Upload the zip of a recording; return its id."""
    return client.post("/v1/recordings", content=content, headers=ZIP).json()["id"]


def manual_runs(count=1, scatter=0.0):
    """Yield squares as a person would measure them: odometry says (0, 0, 0)."""
    chance = np.random.default_rng(1)
    centres = square_returns(NOMINAL, TRUE, 4.0)
    for turn, centre in zip(("cw", "ccw"), centres, strict=True):
        for _ in range(count):
            x, y, theta = centre + scatter * chance.standard_normal(3) * (1.0, 1.0, 0.1)
            yield {
                "direction": turn,
                "after": {"x": x, "y": y, "theta": math.remainder(theta, math.tau)},
                "calculated": {"x": 0.0, "y": 0.0, "theta": 0.0},
            }


def started(client, **options):
    """Start a session; return its path."""
    answer = client.post(SESSIONS, json={"side": 4.0, "runs": 2, **options})
    assert answer.status_code == 201, answer.text
    return f"{SESSIONS}/{answer.json()['id']}"


def sampled(client, path, count=2, scatter=0.0):
    """Post runs that a person measured."""
    for run in manual_runs(count, scatter):
        answer = client.post(f"{path}/samples", json=run)
        assert answer.status_code == 201, answer.text
