"""The live filter: the same drive from another start is the same estimate, moved."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omnimate.ipec.filter.estimate import estimate
from omnimate.ipec.filter.live import Filter
from omnimate.ipec.filter.prior import FilterNoise
from omnimate.ipec.filter.smoother import smooth
from omnimate.motion.paths import free
from omnimate.vcan_sim.floor import Floor, bumps_under
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth
from omnimate.vehicle.sample import Sample
from omnimate.vehicle.se2 import compose

NAN = (math.nan,) * 7
START = np.array([3.0, -7.0, 2.0])


@pytest.fixture(scope="module")
def drive():
    robot = reference_vehicle()
    bumps = bumps_under("a.left", 3, 1.0, 6.0)
    return simulate(robot, Truth(robot, floor=Floor(bumps=bumps), seed=3), free(1, 1))


@pytest.mark.slow
@pytest.mark.parametrize("method", [estimate, smooth])
def test_from_another_start_the_estimate_is_the_same_one_moved(drive, method):
    here, there = method(drive), method(drive, START)
    assert there.pose_a == pytest.approx(compose(START, here.pose_a), abs=1e-6)
    assert there.pose_b == pytest.approx(compose(START, here.pose_b), abs=1e-6)
    assert there.sigma_a[:, 2] == pytest.approx(here.sigma_a[:, 2], abs=1e-9)
    assert np.hypot(*there.sigma_a[:, :2].T) == pytest.approx(np.hypot(*here.sigma_a[:, :2].T), abs=1e-7)
    assert there.nis == pytest.approx(here.nis, rel=1e-4, abs=1e-6, nan_ok=True)


@pytest.mark.parametrize("fixes", [False, True])
def test_at_the_last_sample_filter_and_smoother_agree(drive, fixes):
    taken = drive.poses if fixes else None
    filtered, smoothed = estimate(drive, fixes=taken), smooth(drive, fixes=taken)
    assert smoothed.pose_a[-1] == pytest.approx(filtered.pose_a[-1], abs=1e-9)
    # The smoother averages the poses under several hypotheses, the filter its states.
    assert smoothed.pose_b[-1] == pytest.approx(filtered.pose_b[-1], abs=1e-7)
    assert smoothed.sigma_a[-1] == pytest.approx(filtered.sigma_a[-1])


steps = st.lists(
    st.tuples(st.lists(st.integers(-60, 60), min_size=7, max_size=7), st.integers(0, 2**7 - 1)),
    min_size=1,
    max_size=20,
)


@pytest.mark.slow
@settings(max_examples=40)
@given(steps)
def test_whatever_the_encoders_read_the_estimate_stays_finite_and_its_covariance_one(steps):
    robot = reference_vehicle()
    filter_ = Filter(robot)
    state = filter_.start()
    counts = np.array([encoder.zero if column > 3 else 0 for column, encoder in enumerate(robot.encoders)])
    for index, (change, mask) in enumerate(steps):
        counts = counts + change
        present = tuple(index == 0 or bool(mask >> column & 1) for column in range(7))
        state = filter_.step(state, Sample(index, 0.015 * index, tuple(counts.tolist()), present, NAN, NAN))
        assert np.isfinite(state.record["mean"]).all()
        covariance = state.filters["covariance"]
        assert covariance == pytest.approx(covariance.transpose(0, 2, 1), abs=1e-12)
        assert np.linalg.eigvalsh(covariance).min() > -1e-9


def test_a_floor_that_is_known_to_be_rougher_makes_the_pose_less_certain(drive):
    smooth_floor = estimate(drive, noise=FilterNoise(trust=1e6))
    rough_floor = estimate(drive, noise=FilterNoise(roughness=2e-3, trust=1e6))
    assert np.all(rough_floor.sigma_a[-1] > smooth_floor.sigma_a[-1])
