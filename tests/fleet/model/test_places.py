from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from omnimate.fleet.model.effects import effects_of, floors_of
from omnimate.fleet.model.evidence import AllCrossings
from omnimate.fleet.model.places import BadPlace, find_places
from omnimate.fleet.model.roughness import roughness_of
from omnimate.fleet.model.scores import REACH, grid_of, score_map
from omnimate.fleet.segments import segments_of
from omnimate.vcan_sim.hall.hall import hall_lap
from omnimate.vcan_sim.hall.ills import Ill
from omnimate.vcan_sim.hall.places import Place
from omnimate.vehicle.floor import CONCRETE_ROUGHNESS
from tests.fleet.conftest import evidence_of_lap

DAYS = 20


@pytest.fixture(scope="module")
def bad_hall(plain_hall):
    oil = Place("oil", 20.0, 15.0, reach=0.5, size=0.03)
    slope = Place("slope", 10.0, 20.0, reach=0.8, size=0.01, direction=1.0)
    return replace(plain_hall, places=(oil, slope))


@pytest.fixture(scope="module")
def evidence(bad_hall):
    return [evidence_of_lap(bad_hall, robot, day) for day in range(DAYS) for robot in bad_hall.robots]


@pytest.fixture(scope="module")
def found(evidence):
    return find_places(evidence, grid_of(evidence))


def test_an_oily_patch_and_a_slope_are_found_where_they_are_as_what_they_are(found, bad_hall):
    assert [place.effect for place in found] == ["loss", "creep"]
    for place, true in zip(found, bad_hall.places, strict=True):
        away = np.array([place.x - true.x, place.y - true.y])
        assert away @ np.linalg.solve(place.covariance, away) < chi2.isf(0.01, 2)
        assert np.sqrt(np.linalg.eigvalsh(place.covariance)[-1]) < 0.3


def test_their_sizes_come_out(found):
    oil, slope = found
    assert oil.size[0] == pytest.approx(0.03, abs=5.0 * oil.sigma[0] + 0.006)
    assert np.arctan2(slope.size[1], slope.size[0]) == pytest.approx(1.0, abs=0.5)


def test_places_that_are_known_from_the_night_before_are_found_again(found, evidence):
    again = find_places(evidence, grid_of(evidence), found)
    assert [place.effect for place in again] == [place.effect for place in found]
    for before, after in zip(found, again, strict=True):
        spread = np.sqrt(np.trace(before.covariance))
        assert np.hypot(after.x - before.x, after.y - before.y) < 3.0 * spread


def test_a_good_floor_with_sick_robots_shows_no_place(plain_hall):
    ills = (Ill("wheel_diameter", "a.left", 0, 2e-3), Ill("wheelbase", "a", 0, 0.02))
    robots = [replace(robot, ills=(ill,)) for robot, ill in zip(plain_hall.robots, ills, strict=False)]
    laps = [evidence_of_lap(plain_hall, robot, day) for day in range(DAYS) for robot in robots]
    assert find_places(laps, grid_of(laps)) == ()


def test_the_score_of_a_candidate_is_that_of_the_place_at_its_cell(evidence):
    some = evidence[:6]
    grid = grid_of(some)
    floors = [np.zeros(len(single.residual)) for single in some]
    scores = score_map(some, floors, grid)
    x, y = (int(at) for at in np.unravel_index(np.argmax(scores.information[..., 0]), grid.shape))
    nothing = np.zeros(1)
    place = BadPlace("loss", *grid.place((x, y)), REACH, np.eye(2), nothing, nothing, 0.0, 0)
    effects = effects_of(place, AllCrossings(some))
    weighed = {number: some[number].floor_precision @ effect for number, effect in effects.items()}
    score = sum(float((weighed[number].T @ some[number].residual)[0]) for number in effects)
    information = sum(float((effects[number].T @ weighed[number])[0, 0]) for number in effects)
    assert scores.score[x, y, 0] == pytest.approx(score)
    assert scores.information[x, y, 0] == pytest.approx(information)


def test_roughness_comes_out_beside_the_places(bad_hall, evidence, found):
    laps = [hall_lap(bad_hall, robot, day, 0, 5.0) for day in range(DAYS) for robot in bad_hall.robots]
    segments = [segments_of(lap)[0] for lap in laps]
    floors = floors_of(found, AllCrossings(evidence))
    assert roughness_of(segments, floors) == pytest.approx(CONCRETE_ROUGHNESS, rel=0.1)
