"""Two services on one PostgreSQL; a database that goes away or is full."""

import time
from concurrent.futures import ThreadPoolExecutor
from threading import Barrier

import pytest
import sqlalchemy

from omnimate.service.event_stream import EventStream
from omnimate.service.robot.connection import simulated_plant
from omnimate.service.robot.robot_thread import RobotThread
from omnimate.service.robot.session_reporter import SessionReporter
from omnimate.service.store import vehicles
from omnimate.service.store.recordings import RecordingStore
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vehicle.file import format_vehicle
from tests.service.conftest import away, manual_runs, sampled, serving, started, until

TERMINATE = (
    "select pg_terminate_backend(pid) from pg_stat_activity "
    "where datname = current_database() and pid <> pg_backend_pid()"
)


@pytest.fixture(scope="module")
def services(postgresql_url):
    """Clients of two services on one PostgreSQL."""
    with serving(postgresql_url) as one, serving(postgresql_url) as another:
        yield one, another


def at_once(*calls):
    """Return the answers of calls that are made at the same time."""
    together = Barrier(len(calls))

    def made(call):
        together.wait(60.0)
        return call()

    with ThreadPoolExecutor(len(calls)) as pool:
        return list(pool.map(made, calls))


def solved(service):
    path = started(service)
    sampled(service, path)
    assert service.post(f"{path}/solve").status_code == 200
    return path


def test_of_two_results_that_two_services_accept_at_once_one_is_refused(services):
    for _ in range(3):
        paths = [solved(service) for service in services]
        before = services[0].get("/v1/vehicles/omnimate").json()["version"]
        answers = at_once(
            *(
                lambda service=service, path=path: service.post(
                    f"{path}/accept", headers={"If-Match": "*"}, json={"force": True}
                )
                for service, path in zip(services, paths, strict=True)
            )
        )
        assert sorted(answer.status_code for answer in answers) == [200, 412]
        assert services[0].get("/v1/vehicles/omnimate").json()["version"] == before + 1


def test_a_version_that_waits_for_another_one_is_checked_against_it(postgresql_url, services):
    """One service has added a version and not committed it; the other one waits, and then refuses."""
    one, another = (service.components.database for service in services)
    vehicle = reference_vehicle()

    def add(database):
        with database.writing() as db:
            return vehicles.add_version(db, vehicle, vehicles.Origin("late"), None).version

    with ThreadPoolExecutor(1) as pool:
        with one.writing() as db:
            version = vehicles.add_version(db, vehicle, vehicles.Origin("first"), None).version
            waiting = pool.submit(add, another)
            engine = sqlalchemy.create_engine(postgresql_url, isolation_level="AUTOCOMMIT")
            query = sqlalchemy.text("select count(*) from pg_locks where not granted")
            with engine.connect() as connection:
                end = time.monotonic() + 60.0
                while connection.scalar(query) == 0 and not waiting.done() and time.monotonic() < end:
                    pass
            engine.dispose()
        assert waiting.result(60.0) == version + 1


def test_of_two_vehicles_of_one_name_that_are_added_at_once_one_is_refused(services):
    headers = {"Content-Type": "application/toml"}
    for number in range(5):
        text = format_vehicle(reference_vehicle()).replace('"omnimate"', f'"twin-{number}"', 1)
        answers = at_once(
            *(
                lambda service=service, text=text: service.post("/v1/vehicles", content=text, headers=headers)
                for service in services
            )
        )
        assert sorted(answer.status_code for answer in answers) == [201, 409]


def test_connections_that_the_server_ends_give_no_error_of_the_service(services, postgresql_url):
    service, run = services[0], next(manual_runs())
    path, engine = started(service), sqlalchemy.create_engine(postgresql_url, isolation_level="AUTOCOMMIT")
    acknowledged = 0
    with engine.connect() as admin:
        for number in range(20):
            admin.execute(sqlalchemy.text(TERMINATE))
            calls = [lambda: service.get(path)]
            if number % 2:
                calls.insert(0, lambda: service.post(f"{path}/samples", json=run))
            for call in calls:
                answer = call()
                assert answer.status_code in {200, 201, 503}, answer.text
                assert answer.status_code != 503 or "Retry-After" in answer.headers
                acknowledged += answer.status_code == 201
    engine.dispose()
    stored = next(answer for _ in range(50) if (answer := service.get(path)).status_code == 200)
    assert len(stored.json()["samples"]) >= acknowledged


def test_a_robot_that_is_lost_while_the_database_is_away_is_read_again(database, monkeypatch, tmp_path):
    recordings = RecordingStore(database, str(tmp_path), 10**9)
    reporter = SessionReporter(database, EventStream().announce, "omnimate", "this", recordings)
    robot = RobotThread(None, simulated_plant(reference_vehicle()), 1.0, reporter)
    robot.start()
    until(lambda: robot.reservation.problem is None)
    monkeypatch.setattr(robot, "_reporter", Away(robot._reporter))
    robot.reservation.reserve("some session")
    robot.reload()
    until(lambda: robot.reservation.session is None)
    monkeypatch.undo()
    until(lambda: robot.reservation.problem is None)
    assert robot._thread.is_alive()
    robot.close()


class Away:
    """A reporter whose database is away."""

    vehicle = interrupted = renew = staticmethod(away)

    def __init__(self, reporter):
        self.announce = reporter.announce


def test_a_full_sqlite_database_refuses_changes_and_goes_on_when_there_is_space(client):
    path, run = started(client), next(manual_runs())
    database = client.components.database
    assert client.post(f"{path}/samples", json=run).status_code == 201

    def limit(pages):  # of every connection, as a full disk would
        @sqlalchemy.event.listens_for(database.engine, "begin", insert=True)
        def set_limit(connection):
            connection.exec_driver_sql(f"PRAGMA max_page_count={pages}")

    limit(1)  # SQLite takes the present size for the limit
    acknowledged, answer = 1, None
    for _ in range(500):
        answer = client.post(f"{path}/samples", json=run)
        if answer.status_code != 201:
            break
        acknowledged += 1
    assert answer.status_code == 503
    assert "the disk is full" in answer.json()["detail"]
    assert len(client.get(path).json()["samples"]) == acknowledged
    limit(1_000_000)
    assert client.post(f"{path}/samples", json=run).status_code == 201
