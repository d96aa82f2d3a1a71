from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from omnimate.fleet.hall.faults import Fault
from omnimate.fleet.hall.hall import draw_hall
from omnimate.fleet.hall.places import Place
from omnimate.fleet.model.evidence import FleetEvidence, weigh_segments
from omnimate.fleet.model.floor import estimate_roughness
from omnimate.fleet.model.places import find_places
from omnimate.fleet.model.scores import SEARCH_RADIUS, make_grid, score_map
from omnimate.fleet.report import BadPlace
from omnimate.vehicle.floor import CONCRETE_ROUGHNESS
from tests.fleet.conftest import evidence_of_lap, features_of_lap

DAYS = 20


@pytest.fixture(scope="module")
def bad_hall(plain_hall):
    oil = Place("oil", 20.0, 15.0, reach=0.5, size=0.03)
    slope = Place("slope", 10.0, 20.0, reach=0.8, size=0.01, direction=1.0)
    return replace(plain_hall, places=(oil, slope))


@pytest.fixture(scope="module")
def features(bad_hall):
    return [features_of_lap(bad_hall, robot, day) for day in range(DAYS) for robot in bad_hall.robots]


@pytest.fixture(scope="module")
def evidence(features):
    return [weigh_segments(lap.segments, lap.crossings, CONCRETE_ROUGHNESS) for lap in features]


@pytest.fixture(scope="module")
def found(evidence):
    return find_places(FleetEvidence(evidence))


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


def test_places_that_are_known_from_the_day_before_are_found_again(found, evidence):
    again = find_places(FleetEvidence(evidence), found)
    assert [place.effect for place in again] == [place.effect for place in found]
    for before, after in zip(found, again, strict=True):
        spread = np.sqrt(np.trace(before.covariance))
        assert np.hypot(after.x - before.x, after.y - before.y) < 3.0 * spread


def test_a_good_floor_with_faulty_robots_shows_no_place(plain_hall):
    faults = (Fault("wheel_diameter", "a.left", 0, 2e-3), Fault("wheelbase", "a", 0, 0.02))
    robots = [
        replace(robot, faults=(fault,)) for robot, fault in zip(plain_hall.robots, faults, strict=False)
    ]
    laps = [evidence_of_lap(plain_hall, robot, day) for day in range(DAYS) for robot in robots]
    assert find_places(FleetEvidence(laps)) == ()


def test_a_slope_that_segments_of_few_directions_cross_is_not_taken_for_a_place_elsewhere():
    """It stands out along these segments for metres: it is named near where it is, or not at all."""
    slope = Place("slope", 18.0, 15.0, reach=0.8, size=0.008, direction=1.2)
    chance = np.random.default_rng(1)
    sides = np.where(np.arange(12) % 2, 32.0, 4.0) + chance.uniform(-1.0, 1.0, 12)
    docks = np.column_stack([sides, 15.0 + chance.uniform(-5.0, 5.0, 12), np.zeros(12)])
    hall = draw_hall(6, 60, faulty=0, places=0, sync_period=0.04, seed=3)
    hall = replace(hall, docks=docks, places=(slope,))
    laps = [evidence_of_lap(hall, robot, day) for day in range(25) for robot in hall.robots]
    for place in find_places(FleetEvidence(laps)):
        assert np.hypot(place.x - slope.x, place.y - slope.y) < 1.0


def test_the_score_of_a_candidate_is_that_of_the_place_at_its_cell(evidence):
    some = evidence[:6]
    grid = make_grid(some)
    scores = score_map(some, [np.zeros(len(recording.residual)) for recording in some], grid)
    x, y = (int(at) for at in np.unravel_index(np.argmax(scores.information[..., 0]), grid.shape))
    nothing = np.zeros(1)
    place = BadPlace("loss", *grid.position((x, y)), SEARCH_RADIUS, np.eye(2), nothing, nothing, 0.0, 0)
    effects = FleetEvidence(some).effects_of(place)
    weighed = {number: some[number].floor_precision @ effect for number, effect in effects.items()}
    score = sum(float((weighed[number].T @ some[number].residual)[0]) for number in effects)
    information = sum(float((effects[number].T @ weighed[number])[0, 0]) for number in effects)
    assert scores.score[x, y, 0] == pytest.approx(score)
    assert scores.information[x, y, 0] == pytest.approx(information)


def test_roughness_comes_out_outside_the_places(features, evidence, found):
    effects = FleetEvidence(evidence).sum_effects(found)
    assert estimate_roughness([lap.segments for lap in features], effects) == pytest.approx(
        CONCRETE_ROUGHNESS, rel=0.1
    )
