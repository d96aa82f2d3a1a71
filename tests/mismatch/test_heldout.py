"""Data held out: stretches in which nothing was measured are stretches, too."""

import numpy as np
import pytest

from omnimate.files.importers.robots import single_truck
from omnimate.mismatch import diagnose
from omnimate.mismatch.candidates.terms import term
from omnimate.mismatch.fit import fitted
from omnimate.mismatch.heldout import held_out, nominal_of
from omnimate.mismatch.recording.signals import signals_of
from omnimate.vehicle.parameters import Truck
from omnimate.vehicle.recording import Poses, Recording
from tests.mismatch.conftest import USUAL

PERIOD, SAMPLES = 0.05, 2400
ROBOT = single_truck("robot", Truck(0.2, 0.084, 0.084), 2796.8, PERIOD)


def test_poses_of_the_first_half_only_are_held_out_in_its_stretches():
    time = PERIOD * np.arange(SAMPLES)
    speed, turn = 0.2 + 0.1 * np.sin(0.3 * time), 0.5 * np.sin(0.11 * time)
    ways = np.cumsum(np.stack([speed - 0.1 * turn, speed + 0.1 * turn], axis=1) * PERIOD, axis=0)
    counts = np.rint(ways / abs(ROBOT.metres_per_count("a.left"))).astype(np.int64)
    heading = np.cumsum(turn * PERIOD)
    path = np.cumsum(speed[:, None] * np.stack([np.cos(heading), np.sin(heading)], axis=1) * PERIOD, axis=0)
    seen = np.arange(0, SAMPLES // 2, 200)
    pose = np.column_stack([path, heading])[seen]
    pose += 2e-3 * np.random.default_rng(3).normal(size=pose.shape)
    poses = Poses(time[seen], np.full(len(seen), "a"), pose, np.full(pose.shape, 2e-3))
    answer = diagnose([Recording(ROBOT, time, counts, np.ones(counts.shape, bool), poses)])
    assert answer.fit is not None
    assert answer.fit.heldout.before < 2.0


def test_a_fit_without_any_of_its_effects_predicts_what_the_robot_as_described_does(drive, effect):
    recording = drive(effect("joint_bias", "joint_a", bias=5e-3))
    fit = fitted([signals_of(recording)], USUAL, [term("joint_bias", "joint_a")], [np.zeros(1)])
    whole = held_out(nominal_of(fit), fit)
    empty = held_out(nominal_of(fit), fit, whole.kind, range(len(list(fit.everything()))))
    assert whole.gain.sum() > 100.0
    assert empty.gain.sum() == pytest.approx(0.0, abs=0.01 * whole.gain.sum())
    assert all(effects == () for effects in empty.effects)
