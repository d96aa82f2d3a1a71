import pytest

from omnimate.fleet.features import RecordingFeatures, name_kind
from omnimate.fleet.hall.hall import date_of, draw_hall, hall_lap, write_store
from omnimate.fleet.model.evidence import weigh_segments
from omnimate.fleet.segments import cut_segments
from omnimate.vehicle.floor import CONCRETE_ROUGHNESS


def features_of_lap(hall, robot, day, minutes=5.0):
    segments, crossings = cut_segments(hall_lap(hall, robot, day, 0, minutes))
    return RecordingFeatures(robot.vehicle.name, name_kind(robot.vehicle), date_of(day), segments, crossings)


def evidence_of_lap(hall, robot, day, minutes=5.0):
    lap = features_of_lap(hall, robot, day, minutes)
    return weigh_segments(lap.segments, lap.crossings, CONCRETE_ROUGHNESS)


@pytest.fixture(scope="session")
def plain_hall():
    """Return a hall whose floor and robots are as they should be."""
    return draw_hall(3, 30, faulty=0, places=0)


@pytest.fixture(scope="session")
def store(tmp_path_factory):
    """Return a store of three robots on two days, as its folder."""
    folder = tmp_path_factory.mktemp("store")
    write_store(draw_hall(3, 5, faulty=0, places=0, sync_period=0.04), folder, range(2), 1, 1.0)
    return folder
