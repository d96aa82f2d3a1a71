from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from omnimate.fleet.hall.hall import draw_hall, hall_lap
from omnimate.fleet.hall.ills import Ill
from omnimate.fleet.hall.places import Place
from omnimate.fleet.model.effects import effects_of, floors_of
from omnimate.fleet.model.evidence import AllCrossings
from omnimate.fleet.model.floor import roughness_of
from omnimate.fleet.model.places import BadPlace, find_places
from omnimate.fleet.model.scores import REACH, grid_of, score_map
from omnimate.fleet.segments import segments_of
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


def test_a_slope_that_ways_of_few_directions_cross_is_not_taken_for_a_place_elsewhere():
    """It stands out along these ways for metres: it is named near where it is, or not at all."""
    slope = Place("slope", 18.0, 15.0, reach=0.8, size=0.008, direction=1.2)
    chance = np.random.default_rng(1)
    sides = np.where(np.arange(12) % 2, 32.0, 4.0) + chance.uniform(-1.0, 1.0, 12)
    docks = np.column_stack([sides, 15.0 + chance.uniform(-5.0, 5.0, 12), np.zeros(12)])
    hall = draw_hall(6, 60, sick=0, places=0, sync_period=0.04, seed=3)
    hall = replace(hall, docks=docks, places=(slope,))
    laps = [evidence_of_lap(hall, robot, day) for day in range(25) for robot in hall.robots]
    for place in find_places(laps, grid_of(laps)):
        assert np.hypot(place.x - slope.x, place.y - slope.y) < 1.0


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
