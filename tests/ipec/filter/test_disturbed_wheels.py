"""The test for disturbed wheels: what a wheel's loss explains is a part of the innovations, never more."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omnimate.ipec.filter.disturbed_wheels import (
    TWO_BUMPS_PROBABILITY,
    doubt_heading,
    explained_by_input,
    inputs_to_examine,
    learn_noise,
)
from omnimate.ipec.filter.live import Filter
from omnimate.ipec.filter.records import AHEAD, INPUTS, JOINT_A, LINK, SIDES, FilterState, OpenFilter
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vehicle.compiled import record

many = settings(max_examples=60)
seeds, wheels = st.integers(0, 2**32 - 1), st.integers(0, 3)


def explained(states, wheel, information, pull, alert=0.0):
    filters = record(OpenFilter)
    filters["alert"] = alert
    return explained_by_input(states[0], filters[0], wheel, information, pull)


def positive(chance):
    root = chance.normal(size=(3, 3))
    return root @ root.T + 0.1 * np.eye(3)


def predicted(chance, travel=0.01):
    states = record(FilterState)
    states["inputs"][0] = chance.normal(size=(6, 8))
    states["step_travel"][0] = travel * np.sign(chance.normal(size=4))
    states["speed"] = states["speed_before"] = 0.3
    return states


@many
@given(seeds, wheels)
def test_a_wheel_explains_at_most_the_whole_squared_innovation(seed, wheel):
    chance = np.random.default_rng(seed)
    states, information, offsets = predicted(chance), positive(chance), chance.normal(size=3)
    pull = information @ offsets
    score = explained(states, wheel, information, pull)
    assert 0.0 <= score <= offsets @ pull * (1.0 + 1e-9)


@many
@given(seeds, wheels, st.floats(1e-4, 1.0))
def test_innovations_that_a_loss_makes_are_explained_by_it_wholly_and_by_a_gain_not_at_all(seed, wheel, lost):
    chance = np.random.default_rng(seed)
    states, information = predicted(chance), positive(chance)
    direction = states["inputs"][0, JOINT_A : JOINT_A + 3, wheel]
    by_loss = -lost * np.sign(states["step_travel"][0, wheel]) * direction
    pull = information @ by_loss
    assert explained(states, wheel, information, pull) == pytest.approx(by_loss @ pull, rel=1e-9)
    assert explained(states, wheel, information, -pull) == 0.0


@many
@given(seeds, wheels)
def test_a_wheel_that_stands_or_is_distrusted_already_explains_nothing(seed, wheel):
    chance = np.random.default_rng(seed)
    information = positive(chance)
    pull = information @ chance.normal(size=3)
    standing = predicted(chance, travel=0.0)
    assert explained(standing, wheel, information, pull) == 0.0
    assert explained(predicted(chance), wheel, information, pull, alert=0.05) == 0.0


@many
@given(seeds, wheels, st.floats(0.0, 0.9))
def test_a_wheel_that_brakes_may_gain_what_it_would_else_have_to_lose(seed, wheel, slower):
    chance = np.random.default_rng(seed)
    states, information = predicted(chance), positive(chance)
    gain = np.sign(states["step_travel"][0, wheel]) * states["inputs"][0, JOINT_A : JOINT_A + 3, wheel]
    pull = information @ gain
    states["speed_before"] = 0.3
    states["speed"] = 0.3 * slower
    assert explained(states, wheel, information, pull) == pytest.approx(gain @ pull, rel=1e-9)
    states["speed"] = 0.3
    assert explained(states, wheel, information, pull) == 0.0


def test_a_push_that_explains_alone_what_no_wheel_does_comes_before_two_wheels(robot):
    """A push in a kilometre against a bump in a metre: what wheels leave must be far out of the noise."""
    settings_ = Filter(robot).settings
    assert inputs_to_examine(settings_[0], 0, 150.0, 2.0) == (SIDES, AHEAD)
    assert inputs_to_examine(settings_[0], 0, 10.0, 2.0) == (0, SIDES)
    assert inputs_to_examine(settings_[0], 0, 150.0, 100.0) == (0, SIDES)
    assert inputs_to_examine(settings_[0], 3, 150.0, 100.0) == (SIDES, INPUTS)


@many
@given(seeds, st.integers(SIDES, AHEAD - 1), st.floats(1e-4, 0.05))
def test_a_push_may_be_two_bumps_that_turn_both_trucks_and_not_the_link(seed, truck, pushed):
    """The link turned by a push, or did not: its heading gets the mean square of that."""
    chance = np.random.default_rng(seed)
    states, filters, information = predicted(chance), record(OpenFilter), positive(chance)
    states["information"][0] = information
    states["pull"][0] = information @ (pushed * states["inputs"][0, JOINT_A : JOINT_A + 3, truck])
    doubt_heading(states[0], filters[0], truck)
    turned = pushed * states["inputs"][0, LINK, truck]
    assert filters["covariance"][0, LINK, LINK] == pytest.approx(TWO_BUMPS_PROBABILITY * turned**2)
    assert np.count_nonzero(filters["covariance"]) == 1


@many
@given(seed=seeds)
def test_a_step_teaches_no_more_noise_than_a_distrusted_input_has(seed):
    given_, chance = Filter(reference_vehicle()).settings, np.random.default_rng(seed)
    states, filters = predicted(chance), record(OpenFilter)
    states["step_distance"] = 0.05
    filters["input_variance"] = 1.0
    learn_noise(given_[0], states[0], filters[0], positive(chance), 1e6 * chance.normal(size=3), 10.0)
    most = 2.0 * (given_["distrust"][0] * 0.05) ** 2  # of each of a level's two inputs
    assert 0.0 < filters["learned"][0, :, 0].max() <= most * (1.0 + 1e-12)
