"""The smoother: it ends where the filter ends, begins where it started, and is better in between."""

import numpy as np
import pytest

from omnimate.effects.crossing import cable_loss
from omnimate.ipec.filter.estimate import estimate
from omnimate.ipec.filter.prior import Prior
from omnimate.ipec.filter.smoother import smooth
from omnimate.motion.paths import rounded_rectangle
from omnimate.vcan_sim.floor import Floor, bumps_under
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth
from omnimate.vehicle.recording import Poses
from omnimate.vehicle.sonar import Sonar
from tests.ipec.conftest import SIGMA, noisy


def drive(robot, seed, laps=1, bumps=()):
    truth = Truth(robot, floor=Floor(bumps=bumps), sonar=Sonar(sigma=0.0), seed=seed)
    return simulate(robot, truth, rounded_rectangle(4.0, 2.5, ["cw"] * laps))


@pytest.mark.slow
def test_it_begins_where_it_was_put(robot):
    recording = drive(robot, 1)
    start = np.array([1.0, 2.0, 3.0])
    smoothed = smooth(recording, start)
    assert smoothed.pose_a[0] == pytest.approx(start, abs=1e-9)
    assert smoothed.sigma_a[0] == pytest.approx([0.0] * 3, abs=1e-6)


@pytest.mark.slow
def test_a_fix_at_the_end_corrects_the_way_before_it(robot):
    """Dead reckoning from both ends: the middle is half as uncertain, and the error as large as it says."""
    errors, sigmas, forward = [], [], []
    for seed in range(12):
        recording = drive(robot, seed, laps=2)
        fixes = recording.poses
        known = np.flatnonzero(fixes.body == "a")
        middle = int(known[1])
        kept = np.setdiff1d(np.arange(len(fixes.time)), np.flatnonzero(fixes.time == fixes.time[middle]))
        rest = noisy(Poses(fixes.time[kept], fixes.body[kept], fixes.pose[kept], fixes.sigma[kept]), seed)
        place = int(np.searchsorted(recording.time, fixes.time[middle], side="right")) - 1
        prior = Prior(joint=np.radians(0.001), link=1e-5, ratio=1e-6, wheelbase=1e-6, scale=1e-6)
        smoothed = smooth(recording, sigma=SIGMA, fixes=rest, prior=prior)
        errors.append(smoothed.pose_a[place] - fixes.pose[middle])
        sigmas.append(smoothed.sigma_a[place])
        forward.append(estimate(recording, sigma=SIGMA, fixes=rest, prior=prior).sigma_a[place])
    z = np.array(errors)[:, :2] / np.array(sigmas)[:, :2]
    assert np.all(np.array(sigmas)[:, :2] <= np.array(forward)[:, :2])
    assert 0.3 < np.mean(z**2) < 2.0


def test_it_knows_what_bumps_cost(robot):
    recording = drive(robot, 4, bumps=bumps_under("b.left", 5, 1.0, 9.0))
    lost = 5 * cable_loss(0.075, 0.010)
    assert smooth(recording).lost[:, 2].sum() == pytest.approx(lost, rel=0.15)


def test_it_never_claims_more_uncertainty_than_the_filter(robot):
    recording = drive(robot, 2)
    smoothed, filtered = smooth(recording), estimate(recording)
    assert np.all(smoothed.sigma_a <= filtered.sigma_a * 1.05 + 5e-4)
