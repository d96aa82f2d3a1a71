"""Absolute poses in the filter: Kalman's update, whatever is not measured stays."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omnimate.ipec.filter.fixes import UNSTATED_SIGMA, fix_at_sample, fix_records
from omnimate.ipec.filter.live import Filter, FilteredState
from omnimate.ipec.filter.poses import fill_pose, fill_pose_jacobian
from omnimate.ipec.filter.records import HYPOTHESIS_COUNT, LENGTH, STATES, FilterState, OpenFilter
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vehicle.arcs import arc, integrate
from omnimate.vehicle.compiled import layout, record
from omnimate.vehicle.recording import Poses, Recording
from omnimate.vehicle.se2 import wrap

many = settings(max_examples=40)
seeds, trucks = st.integers(0, 2**32 - 1), st.integers(0, 1)


def state_by(seed):
    chance = np.random.default_rng(seed)
    states, root = record(FilterState), chance.normal(size=(STATES, STATES))
    states["mean"][0] = 0.1 * chance.normal(size=STATES)
    states["mean"][0, LENGTH] = 1.0
    states["weight"][0, 0] = states["is_linked"] = 1.0
    filters = np.zeros(HYPOTHESIS_COUNT, layout(OpenFilter))
    filters["covariance"] = 1e-3 * root @ root.T
    filters["number"], filters["is_active"] = np.arange(HYPOTHESIS_COUNT), 1
    return states, filters


def pose_of(both, truck):
    (states, filters), pose, sigma = both, np.empty(3), np.empty(3)
    fill_pose(states["mean"][0] + filters["offset"][0], filters["covariance"][0], truck, pose, sigma)
    return pose, sigma


def fix(both, truck, pose, sigma):
    before = FilteredState(*both)
    after = Filter(reference_vehicle()).fix(before, pose, sigma, "ab"[truck])
    return after.record, after.filters


@many
@given(seeds, trucks, st.integers(0, 2))
def test_one_coordinate_is_kalmans_update(seed, truck, axis):
    states, filters = state_by(seed)
    pose, _ = pose_of((states, filters), truck)
    rows = np.empty((3, STATES))
    fill_pose_jacobian(states["mean"][0], truck, rows)
    measured, sigma = np.full(3, np.nan), np.full(3, 0.02)
    measured[axis] = pose[axis] + 0.01
    after, after_filters = fix((states, filters), truck, measured, sigma)
    covariance, row = filters["covariance"][0], rows[axis]
    gain = covariance @ row / (row @ covariance @ row + 0.02**2)
    open_mean = after["mean"][0] + after_filters["offset"][0]
    assert open_mean == pytest.approx(states["mean"][0] + 0.01 * gain, abs=1e-9)
    updated = covariance - np.outer(gain, row @ covariance)
    assert after_filters["covariance"][0] == pytest.approx(updated, rel=1e-6, abs=1e-12)


@many
@given(seeds, trucks)
def test_a_fix_never_makes_a_state_less_certain_and_keeps_the_covariance_symmetric(seed, truck):
    start = state_by(seed)
    after = fix(start, truck, (0.0, 0.0, 0.0), (0.01, 0.01, 0.01))
    before, covariance = start[1]["covariance"][0], after[1]["covariance"][0]
    assert np.all(np.diag(covariance) <= np.diag(before) * (1.0 + 1e-9))
    assert covariance == pytest.approx(covariance.T, abs=1e-12)
    assert np.linalg.eigvalsh(covariance).min() > -1e-9


@many
@given(seeds, trucks)
def test_a_fix_without_a_measurement_changes_nothing(seed, truck):
    states, filters = state_by(seed)
    for sigma in ([0.1] * 3, [np.nan] * 3):
        after, after_filters = fix((states, filters), truck, [np.nan] * 3, sigma)
        assert after["mean"][0] + after_filters["offset"][0] == pytest.approx(states["mean"][0], abs=1e-12)
        assert np.array_equal(after_filters["covariance"], filters["covariance"])


@many
@given(seeds, st.integers(-3, 3))
def test_a_heading_is_the_same_after_whole_turns(seed, turns):
    states = state_by(seed)
    measured = np.array([np.nan, np.nan, 0.3])
    here, _ = fix(states, 0, measured, [0.1] * 3)
    there, _ = fix(states, 0, measured + 2.0 * np.pi * turns, [0.1] * 3)
    assert there["mean"] == pytest.approx(here["mean"], abs=1e-6)


@many
@given(seeds)
def test_a_nearly_exact_fix_of_truck_a_is_its_pose_afterwards(seed):
    pose, sigma = pose_of(fix(state_by(seed), 0, (1.0, 2.0, 0.5), [1e-7] * 3), 0)
    assert pose[:2] == pytest.approx([1.0, 2.0], abs=1e-4)
    assert wrap(pose[2] - 0.5) == pytest.approx(0.0, abs=1e-4)
    assert sigma.max() < 1e-4


@many
@given(st.lists(st.floats(-1.0, 11.0), max_size=10), seeds)
def test_each_fix_belongs_to_the_last_sample_before_it_and_unmeasured_ones_are_left_out(times, seed):
    robot, count = reference_vehicle(), len(times)
    recording = Recording(robot, np.arange(10.0), np.zeros((10, 7), np.int64), np.ones((10, 7), bool))
    chance = np.random.default_rng(seed)
    pose = np.where(chance.random((count, 1)) < 0.3, np.nan, chance.normal(size=(count, 3)))
    fixes = Poses(np.array(times), np.array(["a"] * count), pose, np.zeros((count, 3)))
    records = fix_records(recording, fixes)
    known = [time for time, row in zip(times, pose, strict=True) if not np.isnan(row).all()]
    expected = sorted(min(max(int(np.floor(time)), 0), 9) for time in known)
    assert records["sample"].tolist() == expected
    assert (records["sigma"] > 0.0).all()


@pytest.mark.parametrize(("name", "number"), [("a", 0), ("b", 1)])
@pytest.mark.parametrize("missing", [slice(None), "a.left", "b.right"])
def test_a_fix_after_its_sample_is_taken_back_by_the_travel_of_its_own_wheels(name, number, missing):
    """From the last sample in which all four wheels were read, as both trucks move together."""
    robot = reference_vehicle()
    rates = {"a.left": 100, "a.right": 250, "b.left": -300, "b.right": -50}
    counts = np.outer(np.arange(10), [rates.get(channel, 0) for channel in robot.channels])
    present = np.ones((10, 7), bool)
    present[5:7, missing if isinstance(missing, slice) else robot.channels.index(missing)] = False
    recording = Recording(robot, np.arange(10.0), np.where(present, counts, counts[4]), present)
    quarters = np.array([[0.25 * rates[f"{name}.{side}"]] for side in ("left", "right")])
    travel = quarters * [[robot.metres_per_count(f"{name}.{side}")] for side in ("left", "right")]
    quarter = arc(travel[0], travel[1], robot.trucks[name].wheelbase)
    path = integrate(np.tile(quarter, (36, 1)), (1.0, 2.0, 0.5))
    times = np.array([3.0, 3.25, 4.75, 6.5, 9.0, 11.0])
    places = np.minimum(4.0 * times, 36).astype(int)
    fixes = Poses(times, np.array([name] * 6), path[places], np.full((6, 3), 1e-3))
    records = fix_records(recording, fixes)
    assert (records["truck"] == number).all()
    for pose, motion, sample in zip(records["pose"], records["motion"], [3, 3, 4, 4, 9, 9], strict=True):
        at_sample = path[4 * sample]
        assert fix_at_sample(pose, motion, at_sample) == pytest.approx(at_sample, abs=1e-9)


def test_a_fix_that_states_no_sigma_has_the_one_that_is_assumed():
    robot, sigma = reference_vehicle(), np.array([[0.001, np.nan, np.nan]])
    recording = Recording(robot, np.arange(10.0), np.zeros((10, 7), np.int64), np.ones((10, 7), bool))
    fixes = Poses(np.array([5.0]), np.array(["a"]), np.ones((1, 3)), sigma)
    assert fix_records(recording, fixes)["sigma"].tolist() == [[0.001, *UNSTATED_SIGMA[1:]]]
