"""A service in this process, on both databases, with a simulated robot."""

import math
import secrets
import time
from contextlib import contextmanager

import numpy as np
import pytest
import sqlalchemy
from fastapi.testclient import TestClient
from sqlalchemy.exc import OperationalError

from calib.chain import square_returns
from service.app import create_app
from service.parts import make_parts
from service.settings import Settings
from vcan_sim.reference import reference_vehicle
from vehicle.parameters import Truck

SERVER = "postgresql+psycopg://postgres@127.0.0.1:5432/postgres"
NOMINAL = reference_vehicle().trucks["a"]
TRUE = Truck(wheelbase=0.336, wheel_diameter_left=0.1499, wheel_diameter_right=0.1501)
SESSIONS = "/v1/umbmark/sessions"
PATIENCE = 120.0  # [s] that a slow machine may take


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
    url = request.getfixturevalue("postgresql")
    engine = sqlalchemy.create_engine(url)
    with engine.begin() as connection:
        connection.execute(sqlalchemy.text("drop schema public cascade; create schema public"))
    engine.dispose()
    return url


@contextmanager
def serving(url, **options):
    """A client of a service, started and stopped with the block."""
    parts = make_parts(Settings(database=url, pace=1000.0, rate=1e6, **options))
    with TestClient(create_app(parts), base_url="http://127.0.0.1") as client:
        client.parts = parts
        until(lambda: client.get("/readyz").status_code == 200)
        yield client


@pytest.fixture(scope="module")
def service(database_url):
    """A client of a service on each database."""
    with serving(database_url) as client:
        yield client


@pytest.fixture(scope="module")
def client(tmp_path_factory):
    """A client of a service on SQLite."""
    with serving(f"sqlite:///{tmp_path_factory.mktemp('store')}/service.db") as one:
        yield one


def until(true, pause=0.02):
    """Wait for a condition that some thread brings about."""
    end = time.monotonic() + PATIENCE
    while not (found := true()):
        assert time.monotonic() < end, "it did not come"
        time.sleep(pause)
    return found


@pytest.fixture(scope="session", name="until")
def waited():
    """Return a function that waits for a condition."""
    return until


@pytest.fixture(scope="session", name="serving")
def served():
    """Return a context manager that starts and stops a service."""
    return serving


@pytest.fixture(scope="session")
def true_truck():
    """The robot as it is, where runs are measured by hand."""
    return TRUE


@pytest.fixture(scope="session")
def manual_runs():
    """Return a function that yields squares as a person would measure them: odometry says (0, 0, 0)."""
    return _manual_runs


def _manual_runs(count=1, scatter=0.0):
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


@pytest.fixture(scope="session")
def started():
    """Return a function that starts a session and returns its path."""

    def start(client, **options):
        answer = client.post(SESSIONS, json={"side": 4.0, "runs": 2, **options})
        assert answer.status_code == 201, answer.text
        return f"{SESSIONS}/{answer.json()['id']}"

    return start


@pytest.fixture(scope="session")
def sampled():
    """Return a function that posts runs by hand."""

    def sample(client, path, count=2, scatter=0.0):
        for run in _manual_runs(count, scatter):
            answer = client.post(f"{path}/samples", json=run)
            assert answer.status_code == 201, answer.text

    return sample
