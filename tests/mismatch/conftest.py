"""Drives of simulated robots, with and without effects."""

import pytest

from motion.paths import figure_eight, free
from vcan_sim.reference import reference_vehicle
from vcan_sim.simulate import simulate
from vcan_sim.truth import Truth


@pytest.fixture(scope="session")
def drive():
    """Return a function that simulates the reference robot with effects on a figure of eight."""

    def driven(*effects, seed=4, laps=2, start_time=0.0):
        vehicle = reference_vehicle()
        truth = Truth(vehicle, seed=seed, effects=effects)
        return simulate(vehicle, truth, figure_eight(1.0, laps), start_time=start_time)

    return driven


__all__ = ["drive", "free"]
