"""Injections: an altered recording is that of a robot with the effect on the motion that was driven."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.effects.stages import replay
from omnimate.files.importers.robots import single_truck
from omnimate.files.recordings.folder import load_recording
from omnimate.vehicle.parameters import Truck
from omnimate.vehicle.recording import Poses, Recording
from studies.datasets.optiodom.drives import differential_sets, each_recording
from studies.mismatch.engines.laws import OF_TRUCKS, OF_WHEELS
from studies.mismatch.engines.rivals import Injection
from studies.mismatch.engines.vocabulary import VOCABULARY
from studies.mismatch.laws.study import library_effect
from studies.mismatch.worlds.injections import drive_of, with_drive, write_pair
from studies.mismatch.worlds.optiodom import block_of, in_sequence

PERIOD, SAMPLES = 0.05, 900
ROBOT = single_truck("robot", Truck(0.2, 0.084, 0.084), 2796.8, PERIOD)
COUNT = abs(ROBOT.metres_per_count("a.left"))
WHEEL_EFFECTS = [name for name in OF_WHEELS if name not in {"latency", "clock_drift"}]
MORE = {
    "radius_step": {"time": 20.0},
    "wheel_eccentricity": {"phase": 0.7},
    "gear_harmonic": {"order": 3.0, "phase": -1.2},
    "slip_patch": {"intervals": [[10.0, 14.0], [30.0, 33.0]]},
    "bump": {"times": [8.0, 21.0]},
    "count_loss": {"above": 0.2},
}
# Counts by which the travel may differ: the rounding of half a count, and a half-count error of the speed on
# which a law depends; a play may not turn round for what jitters by a count.
WITHIN = {"gear_backlash": 2.0, "traction_slip": 1.5, "radius_vs_speed": 1.5}


def driven(seed):
    """Return the recording of a drive at changing speeds, with stops and reversals."""
    chance = np.random.default_rng(seed)
    time = PERIOD * np.arange(SAMPLES)
    marks = np.arange(0.0, time[-1] + 5.0, 5.0)
    speed = np.interp(time, marks, chance.choice([-0.3, 0.0, 0.12, 0.3, 0.4], len(marks)))
    turn = np.interp(time, marks, chance.uniform(-0.8, 0.8, len(marks))) * (speed != 0.0)
    ways = np.cumsum(np.stack([speed - 0.1 * turn, speed + 0.1 * turn], axis=1) * PERIOD, axis=0)
    counts = np.rint(ways / COUNT).astype(np.int64) + chance.integers(-5000, 5000, 2)
    heading = np.cumsum(turn * PERIOD)
    path = np.cumsum(speed[:, None] * np.stack([np.cos(heading), np.sin(heading)], axis=1) * PERIOD, axis=0)
    nothing = np.full((SAMPLES, 3), np.nan)
    poses = Poses(time, np.full(SAMPLES, "a"), np.column_stack([path, heading]), nothing)
    return Recording(ROBOT, time, counts, np.ones(counts.shape, bool), poses)


def physics(injection):
    """Return the project's own effect of an injection."""
    return library_effect(injection.effect, injection.component, injection.parameters)


def injected(recording, injection):
    return with_drive(recording, injection.into([drive_of(recording)])[0])


def at_the_threshold(recording, injection, wheel):
    """Return the way [m] of steps of which counters of whole counts cannot say whether they are too fast."""
    if injection.effect != "count_loss":
        return 0.0
    speeds = [np.abs(block_of(one).speed[:, wheel]) for one in (recording, injected(recording, injection))]
    crossed = max(np.count_nonzero(np.diff(speed > injection.more["above"])) for speed in speeds)
    return 2.0 * (crossed + 1) * injection.size * injection.more["above"] * PERIOD


@given(st.sampled_from(WHEEL_EFFECTS), st.integers(0, 99), st.booleans(), st.floats(0.1, 2.0))
def test_the_effect_in_the_altered_counts_gives_back_the_way_that_was_travelled(effect, seed, left, part):
    recording, wheel = driven(seed), 0 if left else 1
    component = ("a.left", "a.right")[wheel]
    injection = Injection(effect, component, part * VOCABULARY[effect].usual, MORE.get(effect, {}))
    block = block_of(injected(recording, injection))
    travel = np.cumsum(replay(block, [physics(injection)]).travel, axis=0)
    untouched = np.cumsum(block_of(recording).travel, axis=0)
    most = WITHIN.get(effect, 1.0) * COUNT + at_the_threshold(recording, injection, wheel)
    assert np.abs(travel - untouched)[:, wheel].max() <= most
    assert np.array_equal(block.travel[:, 1 - wheel], block_of(recording).travel[:, 1 - wheel])


@given(st.sampled_from(sorted(OF_TRUCKS)), st.integers(0, 99), st.floats(-2.0, 2.0))
def test_a_truck_of_another_wheelbase_turns_as_the_untouched_one_did(effect, seed, part):
    recording = driven(seed)
    size = part * VOCABULARY[effect].usual
    injection = Injection(effect, "a", size if VOCABULARY[effect].parameter == "ratio" else abs(size), {})
    twist = replay(block_of(injected(recording, injection)), [physics(injection)]).twist
    off = np.cumsum(twist - block_of(recording).twist, axis=0)[:, 0]
    assert np.abs(off[:, 0]).max() <= COUNT
    assert np.abs(off[:, 2]).max() <= 1.5 * COUNT / ROBOT.trucks["a"].wheelbase


@given(st.integers(0, 99), st.integers(1, 6))
def test_a_late_counter_shows_what_it_was_some_samples_before(seed, samples):
    recording = driven(seed)
    late = injected(recording, Injection("latency", "a.left", samples * PERIOD, {}))
    shown, was = late.channel_counts("a.left"), recording.channel_counts("a.left")
    assert np.array_equal(shown[samples:], was[:-samples])


@pytest.mark.parametrize(
    ("effect", "size"), [("latency", 0.12), ("clock_drift", 2e-3), ("clock_drift", -2e-3)]
)
def test_aged_poses_are_those_of_the_time_that_the_effect_says(effect, size):
    recording = driven(1)
    injection = Injection(effect, "poses", size, {})
    aged = injected(recording, injection).poses
    start = float(recording.time[0])
    then = aged.time - physics(injection).age(aged.time, start)
    assert then == pytest.approx(recording.poses.time[: len(then)], abs=1e-9)
    assert np.array_equal(aged.pose, recording.poses.pose[: len(then)])


@given(st.integers(0, 99))
def test_an_untouched_drive_gives_back_its_recording_to_the_count(seed):
    recording = driven(seed)
    again = with_drive(recording, drive_of(recording))
    assert np.array_equal(again.counts, recording.counts)
    assert np.array_equal(again.poses.pose, recording.poses.pose)


def test_recordings_in_sequence_follow_each_other_on_one_clock():
    first, second = in_sequence([driven(1), replace(driven(2), time=driven(2).time + 7.0)])
    assert second.time[0] == pytest.approx(first.time[-1] + 60.0)
    assert second.poses.time[0] == pytest.approx(second.time[0] - 7.0, abs=1e-6)


def test_a_case_and_its_twin_are_the_same_runs_of_a_real_robot_with_and_without_the_effect(
    shared_data, tmp_path
):
    sets = [
        place
        for place in differential_sets(shared_data / "real/optiodom")[0]
        if place.parent.name == "ivanjko"
    ]
    labels = write_pair(tmp_path / "injected-0000", sets[:1], 1, 0)
    case, twin = labels["injected-0000"], labels["injected-0000-twin"]
    assert case["twin"] == "injected-0000-twin"
    assert case["recordings"] == twin["recordings"]
    assert twin["effects"] == []
    (effect,) = case["effects"]
    assert 1.0 <= effect["sigmas_above_noise"] <= 31.0
    pairs = [
        [load_recording(tmp_path / case / name) for case in ("injected-0000-twin", "injected-0000")]
        for name in case["recordings"]
    ]
    untouched, altered = pairs[0]
    assert untouched.vehicle == altered.vehicle
    raw = [*dict(each_recording(sets[0])).values()][twin["runs"][0]]
    assert np.array_equal(untouched.counts - untouched.counts[0], raw.counts - raw.counts[0])
    assert any(differ(*pair) for pair in pairs)


def differ(first, second):
    return not (
        np.array_equal(first.counts, second.counts) and np.array_equal(first.poses.time, second.poses.time)
    )
