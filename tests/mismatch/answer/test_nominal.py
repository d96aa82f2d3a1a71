"""A nominal robot misses as much as its own noise levels say, and more than one on a smoother floor."""

import math
from dataclasses import replace

import numpy as np
import pytest

from omnimate.mismatch.answer.nominal import innovation_variance, innovations, open_loop, usual_levels
from omnimate.mismatch.noise.levels import nominal_levels


@pytest.fixture(scope="module")
def nominal(regression, drive, watched):
    shown = regression(watched(drive(laps=1)))
    return shown.with_noise(nominal_levels(shown.windows))


def test_the_innovations_of_a_nominal_robot_are_its_own_noise(nominal):
    assert innovation_variance(nominal.filters, nominal.noise) == pytest.approx(np.ones(len(nominal.channel)))
    assert list(innovations(nominal).values()) == pytest.approx([1.0] * 9)


def test_on_a_smoother_floor_a_nominal_robot_would_miss_more(nominal):
    smooth = nominal.with_noise(replace(nominal.noise, roughness=nominal.noise.roughness / 3.0))
    assert innovations(smooth)["joint_a"] > 1.2


def test_noise_is_usual_from_nominal_to_a_factor_of_3_3(nominal):
    level = nominal.noise.joint_a
    for factor, usual in ((0.4, 1.0), (2.0, 2.0), (30.0, math.exp(1.2))):
        robot = nominal.with_noise(replace(nominal.noise, joint_a=factor * level))
        assert usual_levels(robot).joint_a == pytest.approx(usual * level)


def test_open_loop_it_misses_the_channels_that_the_rerun_shows_by_more_than_from_reading_to_reading(nominal):
    missed = open_loop(nominal)
    assert set(missed) == {"joint_a", "joint_b", "link"} | {
        f"{truck} {what}" for truck in "ab" for what in ("position", "heading")
    }
    [run], [windows] = nominal.filters, nominal.windows
    once = np.sqrt(np.nanmean(run.spread[1:], axis=0))[: windows.linkage]
    assert missed["joint_a"] > 3.0 * once[0]
    assert 0.001 < missed["a heading"] < 0.05
