"""Drives of simulated robots with and without effects, and what is made of them on the way to an answer."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from omnimate.mismatch import diagnose
from omnimate.mismatch.candidates.regression import Regression
from omnimate.mismatch.evidence.posterior import Posterior
from omnimate.mismatch.noise.levels import NoiseLevels
from omnimate.mismatch.recording.signals import signals_of
from omnimate.mismatch.recording.windows import windows_of
from omnimate.motion.paths import figure_eight
from omnimate.vcan_sim.effects import effect_named
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth
from omnimate.vehicle.recording import Poses

# What the simulator's own floor and sensors come to, so that not every test has to estimate it.
USUAL = NoiseLevels(roughness=5e-4, waviness=5e-5, creep=4e-5, joint_a=2e-5, joint_b=2e-5, link=5e-6)


@pytest.fixture(scope="session")
def effect():
    """Return a function that builds an effect by its name."""

    def built(name, component, **values):
        return effect_named(name)(component, **values)

    return built


@pytest.fixture(scope="session")
def drive():
    """Return a function that simulates the reference robot with effects on figures of eight."""

    @cache
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
def diagnosed(drive):
    """Return a function that gives the diagnosis of such a drive."""
    return cache(lambda *effects, **how: diagnose([drive(*effects, **how)]))


@pytest.fixture(scope="session")
def watched():
    """Return a function that adds poses of both trucks to a recording, several in each second."""

    def seen(recording, every=20, sigma=2e-3):
        path = signals_of(replace(recording, poses=None)).path[::every]
        chance = np.random.default_rng(1)
        trucks = list(recording.vehicle.trucks)
        count = len(path) * len(trucks)
        pose = path.reshape(count, 3) + sigma * chance.normal(size=(count, 3))
        time = np.repeat(recording.time[::every], len(trucks))
        poses = Poses(time, np.array(trucks * len(path)), pose, np.full((count, 3), sigma))
        return replace(recording, poses=poses)

    return seen


@pytest.fixture(scope="session")
def regression():
    """Return a function that gives a recording's regression about some effects."""

    def of(recording, noise=USUAL, base=()):
        return Regression([windows_of(signals_of(recording))], noise, base)

    return of


@pytest.fixture(scope="session")
def alone():
    """Return a function that gives what is left of a regression beside no member and no everyday size."""

    def beside(regression):
        nothing = np.zeros(0, np.int64), np.zeros(0)
        return Posterior(regression, [], [], nothing, {}, np.zeros(len(regression.white))).beside(())

    return beside


@pytest.fixture(scope="session")
def usual_noise():
    """Return the levels of the simulator's own floor and sensors."""
    return USUAL
