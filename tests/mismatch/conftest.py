"""Drives of simulated robots, with and without effects."""

import pytest

from omnimate.mismatch.diagnosis import Finding, Where
from omnimate.motion.paths import figure_eight
from omnimate.vcan_sim.effects import effect_named
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth


@pytest.fixture(scope="session")
def effect():
    """Return a function that builds an effect by its name."""

    def built(name, component, **values):
        return effect_named(name)(component, **values)

    return built


@pytest.fixture(scope="session")
def drive():
    """Return a function that simulates the reference robot with effects on figures of eight."""

    def driven(*effects, seed=4, laps=2, start_time=0.0):
        vehicle = reference_vehicle()
        return simulate(
            vehicle,
            Truth(vehicle, seed=seed, effects=effects),
            figure_eight(1.0, laps),
            start_time=start_time,
        )

    return driven


@pytest.fixture(scope="session")
def found():
    """Return a function that builds a finding."""

    def built(effect, component, explained, probability=0.99, intervals=()):
        return Finding(effect, component, probability, (), Where((), intervals, "always"), (), explained)

    return built
