"""The components of the application: what the robot's file does to the database when a service starts."""

from dataclasses import replace

import pytest

from omnimate.files.recordings.folder import load_recording
from omnimate.service.components import Components
from omnimate.service.settings import Settings
from omnimate.service.store import vehicles
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vehicle.file import save_vehicle
from tests.service.conftest import serving, until

ROBOT = reference_vehicle()
CHANGED = replace(ROBOT, trucks={**ROBOT.trucks, "a": replace(ROBOT.trucks["a"], wheelbase=0.35)})


@pytest.fixture
def versions(tmp_path):
    """Return a function that starts a service with a robot, and returns the robot's versions afterwards."""

    def start(vehicle):
        path = tmp_path / "vehicle.toml"
        save_vehicle(vehicle, path)
        settings = Settings(database=f"sqlite:///{tmp_path}/service.db", vehicle=path)
        components = Components(settings)
        with components.database.reading() as db:
            rows = vehicles.versions(db, vehicle.name)
            kept = [vehicles.parameters_of(row) for row in rows]
        components.close()
        return kept[::-1]

    return start


def test_a_new_robot_gets_its_first_version(versions):
    assert versions(ROBOT) == [ROBOT]


def test_a_changed_file_adds_a_version_and_an_unchanged_one_adds_none(versions):
    assert versions(ROBOT) == versions(ROBOT)
    assert versions(CHANGED) == [ROBOT, CHANGED]
    assert versions(CHANGED) == [ROBOT, CHANGED]


def test_a_file_that_equals_a_former_version_adds_none(versions):
    versions(ROBOT)
    versions(CHANGED)
    assert versions(ROBOT) == [ROBOT, CHANGED]


def test_a_fault_of_the_robot_leaves_a_folder_of_the_flight_recorder(tmp_path, monkeypatch):
    cycles = iter(range(1_000_000))

    def fail_later(*_args):
        if next(cycles) > 20:
            raise ZeroDivisionError
        return ()

    monkeypatch.setattr("omnimate.driver.robot.driver.StallDetector.check", fail_later)
    with serving(f"sqlite:///{tmp_path}/service.db", flight_recorder=tmp_path / "flights"):
        (log,) = until(lambda: list(tmp_path.glob("flights/*/can.log")))
    assert len(load_recording(log.parent)) >= 20
