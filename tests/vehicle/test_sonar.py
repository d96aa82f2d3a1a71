"""The sonar calibrator."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.vehicle.sonar import Sonar

poses = st.tuples(st.floats(-1.5, 5.0), st.floats(-5.0, 5.0), st.floats(-0.78, 0.78))


@given(poses)
def test_without_noise_the_solution_is_the_pose(pose):
    sonar = Sonar()
    assert sonar.solve(sonar.ranges(np.array(pose))) == pytest.approx(pose, abs=1e-12)
    assert sonar.fix(np.array(pose), np.zeros(3))[0] == pytest.approx(pose, abs=1e-12)


@given(poses)
def test_the_headings_full_turns_do_not_matter(pose):
    sonar = Sonar()
    turned = np.array([pose[0], pose[1], pose[2] + 4.0 * math.pi])
    assert sonar.ranges(turned) == pytest.approx(sonar.ranges(np.array(pose)), abs=1e-12)


def test_the_default_measures_to_2_mm_and_0_4_degrees():
    _, sigma = Sonar().fix(np.zeros(3), np.zeros(3))
    assert sigma[0] == pytest.approx(0.002)
    assert sigma[1] <= 0.002
    assert math.degrees(sigma[2]) == pytest.approx(0.4, abs=0.005)


@pytest.mark.parametrize("pose", [(0.0, 0.0, 0.0), (0.3, -0.2, 0.4), (1.0, 1.0, -0.6)])
@pytest.mark.parametrize("part", [0.0, 0.003])
def test_the_scatter_of_many_fixes_is_the_sigma_that_they_state(pose, part):
    sonar, chance = Sonar(sigma_per_range=part / 10.0), np.random.default_rng(1)
    fixes = [sonar.fix(np.array(pose), chance.standard_normal(3)) for _ in range(4000)]
    errors = np.array([fix[0] for fix in fixes]) - pose
    stated = np.array([fix[1] for fix in fixes]).mean(axis=0)
    assert errors.std(axis=0) == pytest.approx(stated, rel=0.06)
    assert np.all(np.abs(errors.mean(axis=0)) < 4.0 * stated / math.sqrt(4000))


@pytest.mark.parametrize("pose", [(0.0, 0.0, 1.0), (0.0, 0.0, math.pi), (-4.0, 0.0, 0.0), (0.0, -7.0, 0.0)])
def test_where_no_wall_answers_the_pose_is_unknown(pose):
    fix, sigma = Sonar().fix(np.array(pose), np.zeros(3))
    assert np.isnan(fix).all()
    assert np.isnan(sigma).all()
