from dataclasses import replace

import numpy as np
import pytest

from omnimate.fleet.model.edges import crossing_errors, estimate_edges
from omnimate.fleet.model.evidence import FleetEvidence
from omnimate.fleet.report import BadPlace
from tests.fleet.conftest import evidence_of_lap

# So strong that the floor's roughness is nothing against it.
PATCH = BadPlace("loss", 20.0, 15.0, 0.5, 0.01 * np.eye(2), np.array([0.5]), np.array([0.01]), 1e4, 100)


@pytest.fixture(scope="module")
def laps(plain_hall):
    return [evidence_of_lap(plain_hall, robot, day) for day in range(12) for robot in plain_hall.robots]


def over_the_patch(laps, edge, seed):
    """Return laps that end as a patch lets them end whose edge scatters [half cells], and nothing else."""
    fleet, chance = FleetEvidence(laps), np.random.default_rng(seed)
    effects = fleet.sum_effects([PATCH])
    errors = crossing_errors([replace(PATCH, edge=edge)], fleet)
    return [
        replace(
            lap, residual=effect + (scatter @ chance.normal(size=scatter.shape[1]) if len(scatter) else 0.0)
        )
        for lap, effect, scatter in zip(
            laps, effects, (errors.get(number, ()) for number in range(len(laps))), strict=True
        )
    ]


@pytest.mark.parametrize("edge", [0.0, 0.5, 1.0])
def test_how_much_an_edge_scatters_comes_out_of_its_crossings(laps, edge):
    edges = [
        estimate_edges([PATCH], FleetEvidence(over_the_patch(laps, edge, seed)))[0].edge for seed in range(9)
    ]
    assert np.median(edges) == pytest.approx(edge, rel=0.25, abs=1e-6)


def test_errors_that_are_set_replace_those_set_before(laps):
    fleet = FleetEvidence(laps)
    errors = crossing_errors([replace(PATCH, edge=0.5)], fleet)
    number = next(iter(errors))
    fleet.set_errors({number: 7.0 * errors[number]})
    fleet.set_errors(errors)
    covariance = np.linalg.inv(laps[number].precision) + errors[number] @ errors[number].T
    assert fleet.recordings[number].precision @ covariance == pytest.approx(np.eye(len(covariance)), abs=1e-6)
    projected = fleet.recordings[number].floor_precision @ laps[number].jacobian
    assert np.abs(projected).max() < 1e-6 * np.abs(laps[number].precision @ laps[number].jacobian).max()
    untouched = next(other for other in range(len(laps)) if other not in errors)
    assert fleet.recordings[untouched] is laps[untouched]
