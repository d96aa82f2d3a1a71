"""What a robot did of late: oscillators, recent speeds, and which way it moved since it last reversed."""

import numpy as np
import pytest
from scipy.signal import lsim

from omnimate.effects.variables import recent_mean
from omnimate.mismatch.candidates.quantities import (
    DAMPING,
    FREQUENCIES,
    OSCILLATION,
    RECENT_ANGLES,
    oscillations,
    reversals,
)

PERIOD = 0.01  # [s]
TIME = PERIOD * np.arange(6000)


@pytest.mark.parametrize("number", [0, 3, 7])
def test_both_answers_of_a_frequency_make_up_that_of_a_damped_oscillator(number):
    acceleration = np.random.default_rng(number).normal(size=len(TIME))
    turn = 2.0 * np.pi * FREQUENCIES[number]
    decay = DAMPING * turn  # the poles are -decay +- i turn
    oscillator = ([1.0], [1.0, 2.0 * decay, turn**2 + decay**2])
    _, answer, _ = lsim(oscillator, acceleration, TIME)
    answers = oscillations("turns", np.full(len(TIME), PERIOD), acceleration)
    pair = np.stack(answers[OSCILLATION.format(FREQUENCIES[number], "turns")], axis=1)
    fitted = pair @ np.linalg.lstsq(pair, answer - answer.mean(), rcond=None)[0]
    assert np.corrcoef(fitted, answer)[0, 1] > 0.995


def test_a_robot_that_turns_the_other_way_has_reversed_since_by_as_much():
    yaw = 1e-3 * np.sin(0.3 * TIME)
    both = zip(reversals(yaw), reversals(-yaw), strict=True)
    for number, (curve, mirrored) in enumerate(both):
        assert mirrored == pytest.approx(curve if number % 2 else -curve, abs=1e-9)


def test_of_a_robot_that_hardly_ever_turns_back_no_reversal_is_known():
    forward = np.full(1000, 1e-3)
    assert reversals(forward) == []
    assert reversals(np.append(forward, -1e-3)) == []
    assert len(reversals(np.append(forward, -forward))) == 2 * len(RECENT_ANGLES)


def test_the_direction_of_turns_is_forgotten_by_turning_and_not_in_time():
    yaw = np.concatenate([np.full(300, 1e-3), np.zeros(500), np.full(300, -1e-3)])
    states = [recent_mean(np.abs(yaw), np.sign(yaw), angle) for angle in RECENT_ANGLES]
    for angle, state in zip(RECENT_ANGLES, states, strict=True):
        assert state[299] == state[799] == pytest.approx(1.0 - np.exp(-0.3 / angle))
        assert state[-1] == pytest.approx(-1.0 + np.exp(-0.3 / angle) * (2.0 - np.exp(-0.3 / angle)))


def test_a_recent_value_of_what_is_constant_approaches_it():
    assert recent_mean(np.full(6000, PERIOD), np.full(6000, 0.5), 3.0)[-1] == pytest.approx(0.5, rel=1e-6)
