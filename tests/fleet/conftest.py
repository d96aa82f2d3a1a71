import pytest

from omnimate.fleet.crossings import crossings_of
from omnimate.fleet.hall.hall import draw_hall, hall_lap
from omnimate.fleet.hall.store import date_of
from omnimate.fleet.model.days import kind_of
from omnimate.fleet.model.evidence import evidence_of
from omnimate.fleet.segments import segments_of
from omnimate.vehicle.floor import CONCRETE_ROUGHNESS


def evidence_of_lap(hall, robot, day, minutes=5.0):
    segments, steps = segments_of(hall_lap(hall, robot, day, 0, minutes))
    kind = kind_of(robot.vehicle)
    return evidence_of(
        robot.vehicle.name, kind, date_of(day), segments, crossings_of(steps), CONCRETE_ROUGHNESS
    )


@pytest.fixture(scope="session")
def plain_hall():
    """Return a hall whose floor and robots are as they should be."""
    return draw_hall(3, 30, sick=0, places=0)
