"""The filter of a single truck: dead reckoning between absolute poses, and what they teach of the wheels."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omnimate.ipec.errors import FixError
from omnimate.ipec.filter.prior import Prior
from omnimate.ipec.one_truck import FACTOR, OneTruckFilter, estimate_one_truck, fill_transition
from omnimate.ipec.tracker import OneTruckTracker, fixes_of, start_by_fixes, track_one_truck
from omnimate.motion.paths import rounded_rectangle
from omnimate.vcan_sim.floor import Floor
from omnimate.vcan_sim.reference import reference_single
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth, with_errors
from omnimate.vehicle.arcs import advance
from omnimate.vehicle.odometry import dead_reckon
from omnimate.vehicle.recording import Poses
from omnimate.vehicle.se2 import wrap
from tests.ipec.conftest import followed, thinned
from tests.recordings import samples

ROBOT = reference_single()
WRONG = with_errors(ROBOT, {"a": 1.02}, {"a": 1.004})
SIGMA = np.array([0.005, 0.005, 0.01])


def drive(true=ROBOT, seed=1):
    """Return a drive of a robot that is described as `ROBOT`."""
    truth = Truth(true, floor=Floor(), seed=seed)
    return simulate(ROBOT, truth, rounded_rectangle(3.0, 2.0, ["cw", "ccw"]))


def measured(recording, seed=1):
    """Return the drive's fixes with noise of `SIGMA`."""
    true = recording.poses
    pose = true.pose + SIGMA * np.random.default_rng(seed).standard_normal(true.pose.shape)
    return Poses(true.time, true.body, pose, np.tile(SIGMA, (len(pose), 1)))


@pytest.fixture(scope="module")
def recording():
    return drive()


@pytest.fixture(scope="module")
def wrong():
    return drive(WRONG)


def test_without_fixes_it_is_dead_reckoning(recording):
    missing = thinned(recording)
    poses, sigmas = estimate_one_truck(missing, (1.0, 2.0, 0.3), SIGMA)
    assert poses == pytest.approx(dead_reckon(missing, start=(1.0, 2.0, 0.3)), abs=1e-9)
    assert sigmas[0] == pytest.approx(SIGMA)
    assert (sigmas[-1] > sigmas[0]).all()


def test_live_steps_and_fixes_give_the_poses_of_the_recording(wrong):
    fixes = measured(wrong)
    start = start_by_fixes(wrong, fixes)
    poses, sigmas = estimate_one_truck(wrong, *start, fixes=fixes)
    filter_ = OneTruckFilter(wrong.vehicle)
    for number, state in enumerate(followed(filter_, filter_.start(*start), wrong, fixes)):
        assert state.pose == pytest.approx(poses[number], abs=1e-12)
        assert state.sigma == pytest.approx(sigmas[number], abs=1e-12)


def test_a_fix_between_samples_is_compared_with_the_pose_at_its_time(recording):
    path = dead_reckon(recording)
    middle = 0.5 * (path[:-1] + path[1:])[::40]
    time = 0.5 * (recording.time[:-1] + recording.time[1:])[::40]
    for pose in (middle, middle * [1.0, 1.0, np.nan]):
        fixes = Poses(time, np.full(len(time), "a"), pose, np.full((len(time), 3), 1e-4))
        poses, _ = estimate_one_truck(recording, fixes=fixes)
        assert poses == pytest.approx(path, abs=1e-4)


travels = st.floats(-0.2, 0.2)


@settings(max_examples=50)
@given(travels, travels, st.lists(st.floats(-0.05, 0.05), min_size=3, max_size=3), st.floats(-3.0, 3.0))
def test_the_transition_is_the_derivative_of_the_movement(left, right, factors, heading):
    mean, transition, by = np.array([1.0, -2.0, heading, *factors]), np.empty((6, 6)), 1e-6
    fill_transition(mean, (left, right), 0.34, transition)

    def moved(state):
        one, other, base = 1.0 + state[FACTOR:]
        return np.array(advance(tuple(state[:3]), left * one, right * other, 0.34 * base))

    for column in range(6):
        step = by * (np.arange(6) == column)
        slope = (moved(mean + step) - moved(mean - step)) / (2.0 * by)
        assert transition[:3, column] == pytest.approx(slope, abs=1e-7)
    assert np.array_equal(transition[3:], np.eye(6)[3:])


def test_a_likely_coordinate_is_kalmans_update_and_nan_changes_nothing():
    filter_ = OneTruckFilter(ROBOT)
    state = filter_.start((1.0, 2.0, 3.1), (0.1, 0.2, 0.05))
    after = filter_.fix(state, (1.05, np.nan, -3.1), SIGMA)
    for axis, value in ((0, 1.05), (2, wrap(-3.1 - 3.1) + 3.1)):
        variance = state.sigma[axis] ** 2
        gain = variance / (variance + SIGMA[axis] ** 2)
        assert after.pose[axis] == pytest.approx(state.pose[axis] + gain * (value - state.pose[axis]))
        assert after.sigma[axis] ** 2 == pytest.approx((1.0 - gain) * variance)
    assert (after.pose[1], after.sigma[1]) == (state.pose[1], state.sigma[1])


@settings(max_examples=20)
@given(st.floats(1.0, 1e4))
def test_a_wild_fix_moves_the_estimate_by_three_of_its_standard_deviations_at_most(off):
    filter_ = OneTruckFilter(ROBOT)
    state = filter_.start((0.0, 0.0, 0.0), (0.01, 0.01, 0.01))
    after = filter_.fix(state, (off, 0.0, 0.0), SIGMA)
    assert 0.0 < after.pose[0] <= 3.0 * 0.01


def test_a_robot_that_was_carried_away_is_followed_after_three_poses():
    filter_ = OneTruckFilter(ROBOT)
    state = filter_.start((0.0, 0.0, 0.0), (0.01, 0.01, 0.01))
    places = []
    for _ in range(4):
        state = filter_.fix(state, (5.0, -3.0, 1.0), SIGMA)
        places.append(state.pose)
    assert np.abs(places[2]).max() < 0.2
    assert places[3] == pytest.approx((5.0, -3.0, 1.0), abs=0.01)


def test_fixes_teach_diameters_and_wheelbase(wrong):
    fixes, true = measured(wrong), WRONG.trucks["a"]
    filter_ = OneTruckFilter(wrong.vehicle, prior=Prior(wrong=0.2))
    *_, state = followed(filter_, filter_.start(*start_by_fixes(wrong, fixes)), wrong, fixes)
    mean, covariance = state.record["mean"][0], state.record["covariance"][0]
    nominal = ROBOT.trucks["a"]
    wanted = [
        true.wheel_diameter_left / nominal.wheel_diameter_left - 1.0,
        true.wheel_diameter_right / nominal.wheel_diameter_right - 1.0,
        true.wheelbase / nominal.wheelbase - 1.0,
    ]
    assert (np.abs(mean[FACTOR:] - wanted) < 3.5 * np.sqrt(np.diag(covariance)[FACTOR:])).all()
    assert abs(mean[FACTOR + 1] - mean[FACTOR] - 0.004) < 0.002  # what bends the path


def test_it_knows_its_error():
    """Of calibrated robots, for whom the prior holds: 3 is the mean of a chi-squared sum of three."""
    sums = []
    for seed in range(12):
        recording = drive(seed=seed)
        poses, sigmas = estimate_one_truck(recording, recording.poses.pose[0], 1e-4, prior=Prior(wrong=0.0))
        error = poses[-1] - recording.poses.pose[-1]
        error[2] = wrap(error[2])
        sums.append(np.sum((error / sigmas[-1]) ** 2))
    assert 1.0 < np.mean(sums) < 6.0


def test_it_starts_where_the_first_whole_fix_puts_the_first_sample(recording):
    fixes = measured(recording)
    pose = fixes.pose.copy()
    pose[0, 2] = np.nan
    start, sigma = start_by_fixes(recording, replace(fixes, pose=pose))
    assert np.abs(start - recording.poses.pose[0])[:2].max() < 0.2
    assert abs(wrap(start[2] - recording.poses.pose[0, 2])) < 0.1
    assert (sigma > SIGMA).all()
    with pytest.raises(FixError, match="no fix of truck a has x, y and heading"):
        start_by_fixes(recording, replace(fixes, pose=np.full_like(pose, np.nan)))
    with pytest.raises(FixError):
        fixes_of(replace(recording, poses=None))


def test_a_fix_without_a_stated_sigma_is_used(recording):
    unstated = replace(recording.poses, sigma=np.full_like(recording.poses.sigma, np.nan))
    assert np.isfinite(fixes_of(replace(recording, poses=unstated)).sigma).all()


def test_rows_live_are_those_of_the_recording(recording):
    tracker = OneTruckTracker(recording.vehicle)
    for sample, row in zip(samples(recording), track_one_truck(recording, 0.0), strict=True):
        tracker.step(sample)
        live, at_once = tracker.row().as_dict(), row.as_dict()
        assert [value is None for value in live.values()] == [value is None for value in at_once.values()]
        known = [name for name, value in live.items() if value is not None]
        assert [live[name] for name in known] == pytest.approx([at_once[name] for name in known], abs=1e-9)
    assert live["ipec_x"] is None
