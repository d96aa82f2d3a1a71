"""Data held out: stretches in which nothing was measured are stretches, too."""

from dataclasses import replace

import numpy as np
import pytest

from omnimate.files.importers.robots import single_truck
from omnimate.mismatch import diagnose
from omnimate.mismatch.answer.doubts import MISFIT
from omnimate.mismatch.candidates.terms import term
from omnimate.mismatch.diagnosis import ASSERTED
from omnimate.mismatch.heldout import HELD, held_out
from omnimate.vehicle.parameters import Truck
from omnimate.vehicle.recording import Lap, Poses, Recording, Run
from tests.mismatch.conftest import fit_of

PERIOD, SAMPLES = 0.05, 2400
ROBOT = single_truck("robot", Truck(0.2, 0.084, 0.084), 2796.8, PERIOD)


def recorded(turn, speed, wheelbase=0.2, every=20, until=SAMPLES, seed=3, left=1.0):
    """Return a drive with turn rates [rad/s] and speeds [m/s] (N,) of a robot with a wheelbase [m].

    Its left wheel is larger than it should be by a factor `left`.
    """
    chance = np.random.default_rng(seed)
    time = PERIOD * np.arange(SAMPLES)
    ways = np.stack([speed - 0.5 * wheelbase * turn, speed + 0.5 * wheelbase * turn], axis=1) * PERIOD
    ways += 3e-4 * np.sqrt(np.abs(ways)) * chance.normal(size=ways.shape)
    ways[:, 0] /= left
    counts = np.rint(np.cumsum(ways, axis=0) / abs(ROBOT.metres_per_count("a.left"))).astype(np.int64)
    heading = np.cumsum(turn * PERIOD)
    path = np.cumsum(speed[:, None] * np.stack([np.cos(heading), np.sin(heading)], axis=1) * PERIOD, axis=0)
    seen = np.arange(0, until, every)
    pose = np.column_stack([path, heading])[seen]
    pose += 2e-3 * chance.normal(size=pose.shape)
    poses = Poses(time[seen], np.full(len(seen), "a"), pose, np.full(pose.shape, 2e-3))
    run = Run("free", None, (Lap("none", time[0], time[-1]),))
    return Recording(ROBOT, time, counts, np.ones(counts.shape, bool), poses, run)


def test_poses_of_the_first_half_only_are_held_out_in_its_stretches():
    time = PERIOD * np.arange(SAMPLES)
    turn, speed = 0.5 * np.sin(0.11 * time), 0.2 + 0.1 * np.sin(0.3 * time)
    answer = diagnose([recorded(turn, speed, every=200, until=SAMPLES // 2)])
    assert answer.fit is not None
    assert answer.fit.heldout.before < 2.0


def test_circles_to_either_side_say_of_each_other_that_the_wheelbase_is_wrong():
    """Those to one side alone do not tell it from unequal wheels, which are the rarer fault."""
    turn, speed = np.full((2, SAMPLES), [[0.4], [0.2]])
    answer = diagnose([recorded(turn, speed, 0.204), recorded(-turn, speed, 0.204, seed=4)])
    assert [finding.key for finding in answer.findings] == [("wheelbase", "a")]
    assert answer.fit is not None
    assert answer.fit.heldout.after < 1.2


def test_circles_to_one_side_are_not_held_out_where_they_separate_two_numbers():
    """Those to the other side alone would not say how much is the wheelbase, and how much a wheel."""
    turn, speed = np.full((2, SAMPLES), [[0.4], [0.2]])
    answer = diagnose(
        [recorded(turn, speed, 0.203, left=1.003), recorded(-turn, speed, 0.203, left=1.003, seed=4)]
    )
    assert ("wheelbase", "a") in [finding.key for finding in answer.findings]
    assert answer.fit is not None
    assert HELD["blocks"] in answer.fit.metric
    assert answer.fit.heldout.after < 1.2


def test_a_fit_without_any_of_its_effects_predicts_what_the_robot_as_described_does(drive, effect):
    recording = drive(effect("joint_bias", "joint_a", bias=5e-3))
    fit = fit_of([recording], term("joint_bias", "joint_a"))
    whole = held_out(fit)
    empty = held_out(fit, whole.kind, range(len(list(fit.everything()))))
    assert whole.gain.sum() > 100.0
    assert empty.gain.sum() == pytest.approx(0.0, abs=0.01 * whole.gain.sum())
    assert all(effects == () for effects in empty.effects)


def test_what_no_pose_predicts_of_another_is_no_agreement():
    """At the end of each lap one pose shows how late the left wheel's counts have become, 3 ms a second."""
    time = PERIOD * np.arange(SAMPLES)
    healthy = recorded(np.zeros(SAMPLES), 0.4 * np.sin(2.0 * np.pi * time / 40.0), every=799)
    late = np.interp(0.997 * time, time, healthy.counts[:, 0])
    counts = np.stack([np.rint(late).astype(np.int64), healthy.counts[:, 1]], axis=1)
    answer = diagnose([replace(healthy, counts=counts)])
    assert answer.fit is not None
    assert answer.fit.heldout.after > MISFIT
    assert answer.verdict == "mismatch"
    [finding] = answer.findings
    assert finding.effect == "unknown"
    assert finding.component in {"a.left", "a.right"}
    assert finding.probability >= ASSERTED
