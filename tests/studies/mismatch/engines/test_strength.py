"""The bound: where the noise is known, an effect's strength is what a textbook says it is."""

from dataclasses import replace

import numpy as np
import pytest

from omnimate.vehicle.arcs import integrate
from studies.mismatch.engines.rivals import LARGEST, SEPARATE, Injection, draw, strength_of
from studies.mismatch.engines.strength import Drive, Noise, Poses, Ruler, increments, left_of, residual

PERIOD, SAMPLES, BASE = 0.05, 2000, 0.2
PATH, HEADING = 2e-4, 4e-4  # scatter of the increments [m, rad]
ROOT = 2.0**0.5  # of the increments in a window of the residual


def drives(seed, count=4):
    """Return drives at changing speeds and turn rates, whose poses err by white increments."""
    return [one(np.random.default_rng([seed, number])) for number in range(count)]


def one(chance):
    time = PERIOD * np.arange(SAMPLES)
    marks = np.arange(0.0, time[-1] + 3.0, 3.0)
    speed = np.interp(time, marks, chance.uniform(0.1, 0.5, len(marks)))
    turn = np.interp(time, marks, chance.uniform(-0.8, 0.8, len(marks)))
    way = np.cumsum(np.stack([speed - 0.5 * BASE * turn, speed + 0.5 * BASE * turn], axis=1) * PERIOD, axis=0)
    wheels = np.full(2, 1e-4), np.full(2, 0.042), np.array([BASE])
    drive = Drive(time, way, *wheels, np.zeros((SAMPLES, 0)), 0.0, {})
    noise = chance.normal(size=(SAMPLES - 1, 3)) * [PATH, PATH, HEADING]
    return replace(drive, poses={0: Poses(time, integrate(increments(drive.path(0)) + noise))})


def test_the_residual_of_a_drive_is_the_noise_of_its_increments():
    chance = np.random.default_rng([1, 0])
    missed = residual(one(chance))
    assert list(missed) == ["a"]
    assert missed["a"].std(axis=0) == pytest.approx(ROOT * np.array([PATH, PATH, HEADING]), rel=0.1)


def test_white_noise_whitens_to_the_change_over_its_standard_deviation():
    chance = np.random.default_rng(2)
    noise = Noise.of([{"a": chance.normal(size=(SAMPLES, 3)) * [1.0, 2.0, 4.0]} for _ in range(20)])
    change = np.zeros((SAMPLES, 3))
    change[:, 1] = np.sin(0.3 * np.arange(SAMPLES))
    expected = np.linalg.norm(change[:, 1]) / 2.0
    assert np.linalg.norm(noise.whitened([{"a": change}])) == pytest.approx(expected, rel=0.1)


def test_correlated_noise_hides_what_is_slow_and_not_what_is_quick():
    chance = np.random.default_rng(3)
    walks = [0.02 * np.cumsum(chance.normal(size=(SAMPLES, 3)), axis=0) for _ in range(20)]
    noise, at = Noise.of([{"a": walk} for walk in walks]), np.arange(SAMPLES)[:, None]
    slow, quick = (np.sin(rate * at) * np.ones(3) for rate in (0.02, 2.0))
    assert np.linalg.norm(noise.whitened([{"a": quick}])) > 20.0 * np.linalg.norm(
        noise.whitened([{"a": slow}])
    )


def test_the_strength_of_a_wheelbase_is_its_size_over_the_bound_of_ordinary_least_squares():
    own = drives(4)
    injection = Injection("wheelbase", "a", 0.004, {})
    yaw, way = (np.concatenate([column(drive) for drive in own]) for column in (yaws, ways))
    # how the three numbers change way and yaw, in units of their noise
    white = {
        "wheelbase": np.concatenate((0.0 * yaw, yaw / HEADING)),
        "left": np.concatenate((0.5 * way[:, 0] / PATH, -way[:, 0] / BASE / HEADING)),
        "right": np.concatenate((0.5 * way[:, 1] / PATH, way[:, 1] / BASE / HEADING)),
    }
    expected = 0.004 * left_of(white["wheelbase"], [white["left"], white["right"]])
    assert strength_of(injection, own, Ruler.of(own)) == pytest.approx(expected, rel=0.15)


def yaws(drive):
    return np.diff(drive.way[:, 1] - drive.way[:, 0]) / BASE


def ways(drive):
    return np.diff(drive.way, axis=0)


def test_what_others_explain_is_not_left():
    first, second = np.eye(3)[0], np.eye(3)[1]
    assert left_of(3.0 * first + 4.0 * second, [first]) == pytest.approx(4.0)
    assert left_of(3.0 * first, [first, np.zeros(3)]) == pytest.approx(0.0, abs=1e-12)


def test_injections_are_of_all_strengths_and_sizes_that_robots_have_and_the_same_for_the_same_seed():
    own = drives(5, count=2)
    ruler, chance = Ruler.of(own), np.random.default_rng(6)
    drawn = [draw(own, ruler, chance) for _ in range(25)]
    strengths = np.array([each.strength for each in drawn])
    assert 0.9 <= strengths.min() < 3.0
    assert 15.0 < strengths.max() <= 33.0
    assert all(abs(each.injection.size) <= LARGEST[each.injection.effect] for each in drawn)
    assert draw(own, ruler, np.random.default_rng(6)) == drawn[0]
    for each in drawn:  # what the drives cannot tell apart is acceptable, and nothing else
        assert all(apart < SEPARATE for apart in each.alike.values())
        assert len(each.label()["acceptable"]) == len(each.alike)
        assert each.label()["sigmas_above_noise"] == pytest.approx(each.strength, abs=0.01)
