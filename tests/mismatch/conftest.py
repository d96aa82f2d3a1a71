"""Drives of simulated robots with and without effects, and what is made of them on the way to an answer."""

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from omnimate.effects import effect_named
from omnimate.mismatch import diagnose
from omnimate.mismatch.candidates.regression import Regression, slices_of
from omnimate.mismatch.candidates.terms import Term
from omnimate.mismatch.diagnosis import Finding
from omnimate.mismatch.evidence.candidates import Candidates
from omnimate.mismatch.evidence.posterior import Posterior
from omnimate.mismatch.fit import fitted
from omnimate.mismatch.noise.levels import NoiseLevels
from omnimate.mismatch.recording.signals import signals_of
from omnimate.mismatch.recording.windows import windows_of
from omnimate.motion.paths import figure_eight
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth
from omnimate.vehicle.recording import Poses

# What the simulator's own floor and sensors come to, so that not every test has to estimate it.
USUAL = NoiseLevels(roughness=5e-4, waviness=5e-5, creep=4e-5, joint_a=2e-5, joint_b=2e-5, link=5e-6)


def fit_of(recordings, *terms):
    """Return the fit of effects, from no size of each on."""
    signals = [signals_of(recording) for recording in recordings]
    return fitted(signals, USUAL, terms, [np.zeros(len(term.probes)) for term in terms])


def roughness(noise):
    """Return how rough a floor is in all [m/sqrt(m)]: from window to window, and in waves."""
    return float(np.hypot(noise.roughness, noise.waviness))


def cut(recording, rows):
    """Return a recording of some samples only, of which one may come several times, at its first times."""
    counts = recording.counts[rows]
    return replace(
        recording, time=recording.time[: len(counts)], counts=counts, present=recording.present[rows],
        commands=None, poses=None, run=None,
    )  # fmt: skip


def finding(effect, probability=0.99, explained=1.0, component="b.left", alternatives=()):
    """Return a finding that explains a share."""
    return Finding(effect, component, probability, alternatives, explained=explained)


RATE, SPAN = 4, 120.0  # rows in a second, and seconds of regressions that are drawn by chance


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


@pytest.fixture
def eccentric(drive, effect):
    """Return a function that drives a robot whose wheel b.left is out of round by an amplitude [m] each.

    Of a negative amplitude, the wheel is out of round to the other side.
    """

    def driven(*amplitudes):
        hidden = [
            effect(
                "wheel_eccentricity", "b.left", amplitude=abs(size), phase=0.5 if size > 0.0 else 0.5 - np.pi
            )
            for size in amplitudes
        ]
        return [drive(each, seed=20 + number, laps=1) for number, each in enumerate(hidden)]

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
    """Return a function that gives what is left of a regression beside no member and no background size."""

    def conditional(regression):
        nothing = np.zeros(0, np.int64), np.zeros(0)
        return Posterior(Candidates(regression, [], [], nothing, {})).given(())

    return conditional


def candidate(effect, component, odds=0.01, positive=False, width=1, **fixed):
    """Return a candidate of one column or more."""
    return Term(effect, component, (None,) * width, fixed, float(np.log(odds)), positive)


def drawn(columns, terms, truth, seed, background=None, order=None):
    """Return the posterior of data `X b + e` about candidates with columns X."""
    chance = np.random.default_rng([seed, 1])
    count = int(RATE * SPAN)
    assert columns.shape[0] == count
    data = columns @ truth + chance.normal(size=count)
    time = np.arange(count) / RATE
    order = np.arange(count) if order is None else order
    regression = SimpleNamespace(
        white=np.column_stack([data, columns])[order],
        time=time[order],
        owner=np.zeros(count, int),
        channel=np.zeros(count, int),
        windows=[SimpleNamespace(time=np.array([0.0, SPAN]))],
    )
    places = slices_of((len(term.probes) for term in terms), 1)
    if background is None:
        background = np.zeros(0, np.int64), np.zeros(0)
    names = {
        column: term.key
        for term, place in zip(terms, places, strict=True)
        for column in range(place.start, place.stop)
    }
    return Posterior(Candidates(regression, list(terms), places, background, names))


def waves(informations, seed):
    """Return smooth columns, as drives make them, of some information each."""
    chance = np.random.default_rng([seed, 2])
    time = np.arange(int(RATE * SPAN)) / RATE
    made = []
    for information in informations:
        pace, phase = chance.uniform(0.05, 1.0), chance.uniform(0.0, 2.0 * np.pi)
        column = np.cos(2.0 * np.pi * pace * time + phase) + 0.3 * chance.normal(size=len(time))
        made.append(column * np.sqrt(information / (column @ column)))
    return np.stack(made, axis=1)
