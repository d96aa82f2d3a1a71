from dataclasses import replace

import numpy as np
import pytest

from omnimate.fleet.model.edges import edges_of, errors_of
from omnimate.fleet.model.effects import floors_of
from omnimate.fleet.model.evidence import AllCrossings
from omnimate.fleet.morning import BadPlace
from tests.fleet.conftest import evidence_of_lap

# So strong that the floor's roughness is nothing beside it.
PATCH = BadPlace("loss", 20.0, 15.0, 0.5, 0.01 * np.eye(2), np.array([0.5]), np.array([0.01]), 1e4, 100)


@pytest.fixture(scope="module")
def laps(plain_hall):
    return [evidence_of_lap(plain_hall, robot, day) for day in range(12) for robot in plain_hall.robots]


def over_the_patch(laps, edge, seed):
    """Return laps that end as a patch lets them end whose edge scatters [half cells], and nothing else."""
    crossings, chance = AllCrossings(laps), np.random.default_rng(seed)
    floors = floors_of([PATCH], crossings)
    errors = errors_of([replace(PATCH, edge=edge)], crossings)
    return [
        replace(
            single, residual=floor + (scatter @ chance.normal(size=scatter.shape[1]) if len(scatter) else 0.0)
        )
        for single, floor, scatter in zip(
            laps, floors, (errors.get(number, ()) for number in range(len(laps))), strict=True
        )
    ]


@pytest.mark.parametrize("edge", [0.0, 0.5, 1.0])
def test_how_much_an_edge_scatters_comes_out_of_its_crossings(laps, edge):
    edges = [edges_of([PATCH], AllCrossings(over_the_patch(laps, edge, seed)))[0].edge for seed in range(9)]
    assert np.median(edges) == pytest.approx(edge, rel=0.25, abs=1e-6)


def test_stated_errors_are_taken_as_such_and_those_stated_before_are_forgotten(laps):
    crossings = AllCrossings(laps)
    errors = errors_of([replace(PATCH, edge=0.5)], crossings)
    number = next(iter(errors))
    crossings.doubt({number: 7.0 * errors[number]})
    crossings.doubt(errors)
    covariance = np.linalg.inv(laps[number].precision) + errors[number] @ errors[number].T
    assert crossings.evidence[number].precision @ covariance == pytest.approx(
        np.eye(len(covariance)), abs=1e-6
    )
    beside = crossings.evidence[number].floor_precision @ laps[number].jacobian
    assert np.abs(beside).max() < 1e-6 * np.abs(laps[number].precision @ laps[number].jacobian).max()
    untouched = next(other for other in range(len(laps)) if other not in errors)
    assert crossings.evidence[untouched] is laps[untouched]
