"""Vehicles and their versions in the database: versions are added in order and never changed."""

from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omnimate.service.errors import ModifiedError, StateError
from omnimate.service.store import vehicles
from omnimate.service.store.tables import VehicleRow
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vehicle.file import format_vehicle
from tests.service.conftest import sampled, started

ROBOT = replace(reference_vehicle(), name="robot")
TEST = vehicles.Origin("test")


def wider(millimetres):
    """Return the robot with another wheelbase of truck a."""
    truck = replace(ROBOT.trucks["a"], wheelbase=0.34 + 0.001 * millimetres)
    return replace(ROBOT, trucks={**ROBOT.trucks, "a": truck})


@settings(max_examples=30)
@given(changes=st.lists(st.tuples(st.integers(0, 20), st.none() | st.integers(1, 6)), max_size=6))
def test_a_change_adds_a_version_exactly_where_the_newest_one_was_expected(database, changes):
    with database.writing() as db:
        db.query(VehicleRow).filter(VehicleRow.name == "robot").delete()
        vehicles.create(db, ROBOT, TEST)
    kept = [ROBOT]
    for width, expected in changes:
        with database.writing() as db:
            if expected in {None, len(kept)}:
                row = vehicles.add_version(db, wider(width), TEST, expected)
                kept.append(wider(width))
                assert row.version == len(kept)
            else:
                with pytest.raises(ModifiedError, match=f"is at version {len(kept)}, not {expected}"):
                    vehicles.add_version(db, wider(width), TEST, expected)
    with database.reading() as db:
        rows = vehicles.versions(db, "robot")
        assert [row.version for row in rows] == list(range(len(kept), 0, -1))
        assert [vehicles.parameters_of(row) for row in rows] == kept[::-1]
        assert vehicles.newest(db, "robot").version == len(kept)


def test_a_name_is_given_once(database):
    with database.writing() as db, pytest.raises(StateError, match="exists already"):
        vehicles.create(db, reference_vehicle(), TEST)


def test_the_newest_versions_of_all_vehicles_are_in_the_order_of_their_names(database):
    with database.writing() as db:
        for name in ("zebra", "ant"):
            vehicles.create(db, replace(ROBOT, name=name), TEST)
        vehicles.add_version(db, replace(ROBOT, name="ant"), TEST, 1)
    with database.reading() as db:
        rows = [(row.name, row.version) for row in vehicles.newest_of_all(db) if row.name != "robot"]
    assert rows == [("ant", 2), ("omnimate", 1), ("zebra", 1)]


def test_what_a_person_wrote_stays_as_it_was_written(client):
    text = format_vehicle(replace(ROBOT, name="written")).replace("cob_id = 391", "cob_id = 0x187")
    text = "# measured on a cold morning\n" + text
    headers = {"Content-Type": "application/toml", "If-Match": "*"}
    made = client.post("/v1/vehicles", content=text, headers=headers)
    assert (made.status_code, made.json()["toml"]) == (201, text)
    text = text.replace("cold", "warm")
    client.put("/v1/vehicles/written", content=text, headers=headers)
    assert client.get("/v1/vehicles/written/exports/toml").text == text


@pytest.mark.parametrize("version", ["9" * 5000, "2", "-1", "1.0"])
def test_an_if_match_that_names_no_present_version_is_refused(client, version):
    text = format_vehicle(replace(ROBOT, name="matched"))
    headers = {"Content-Type": "application/toml", "If-Match": f'"{version}"'}
    client.post("/v1/vehicles", content=text, headers=headers)
    assert client.put("/v1/vehicles/matched", content=text, headers=headers).status_code == 412


@pytest.mark.parametrize("name", ["機械 1?#", "a\x7fb", "Größe"])
def test_the_location_of_a_vehicle_leads_to_it_whatever_its_name(client, name):
    """Headers take Latin-1 at most, and a `?` or `#` would end the path: sent as it is, it was a 500."""
    text = format_vehicle(replace(ROBOT, name=name))
    made = client.post("/v1/vehicles", content=text, headers={"Content-Type": "application/toml"})
    assert client.get(made.headers["Location"]).json()["name"] == name
    session = started(client, vehicle=name)
    sampled(client, session)
    client.post(f"{session}/solve")
    accepted = client.post(f"{session}/accept", headers={"If-Match": "*"})
    assert client.get(accepted.headers["Location"]).json()["version"] == 2
