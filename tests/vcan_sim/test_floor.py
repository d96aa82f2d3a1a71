"""The floor."""

import math

import numpy as np
import pytest

from omnimate.motion.paths import umbmark
from omnimate.vcan_sim.errors import SimulationError
from omnimate.vcan_sim.floor import Floor
from omnimate.vcan_sim.plant import Plant
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth
from omnimate.vehicle.floor import CONCRETE_ROUGHNESS
from omnimate.vehicle.sonar import Sonar
from tests.vcan_sim.test_simulate import return_errors


@pytest.mark.parametrize("roughness", [-1e-4, math.nan, math.inf])
def test_a_roughness_that_no_floor_has_is_refused(roughness):
    with pytest.raises(SimulationError, match="roughness"):
        Floor(roughness)


def test_the_heading_scatters_with_the_square_root_of_the_way_whatever_the_step(alone):
    turns = {}
    for dt in (0.005, 0.02):
        headings = []
        for seed in range(200):
            plant = Plant(Truth(alone, floor=Floor(1e-3), servo=1e9, seed=seed), alone)
            for _ in range(round(2.0 / (4.0 * 0.075 * dt))):
                plant.step((4.0, 4.0), dt)
            headings.append(plant.pose("a")[2])
        turns[dt] = np.std(headings)
    wanted = 1e-3 * math.sqrt(2.0 * 2.0) / 0.340
    assert list(turns.values()) == pytest.approx([wanted, wanted], rel=0.2)


def test_a_robot_that_stands_is_not_shaken(alone):
    plant = Plant(Truth(alone, floor=Floor(1e-3)), alone)
    for _ in range(100):
        plant.step((0.0, 0.0), 0.015)
    assert not plant.pose("a").any()


def test_on_concrete_the_return_position_of_a_4_m_square_scatters_by_25_mm_in_x_and_y(alone):
    errors = []
    for seed in range(4):
        truth = Truth(alone, floor=Floor(CONCRETE_ROUGHNESS), sonar=Sonar(sigma=0.0), seed=seed)
        errors += return_errors(simulate(alone, truth, umbmark(runs=40)), "a").tolist()
    scatter = np.std(errors, axis=0)[:2]
    assert len(errors) == 320
    assert scatter == pytest.approx([0.025, 0.025], rel=0.12)  # three standard errors of 320 runs
