"""A step of the correctors: the same drive from another start is the same trajectory, moved."""

import numpy as np
import pytest

from omnimate.ipec.corrector import METHODS, correct
from omnimate.motion.paths import free
from omnimate.vcan_sim.bumps import bumps_under
from omnimate.vcan_sim.floor import Floor
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth
from omnimate.vehicle.recording import Recording
from omnimate.vehicle.se2 import compose

START = np.array([3.0, -7.0, 2.0])


@pytest.fixture(scope="module")
def drive():
    robot = reference_vehicle()
    bumps = bumps_under("a.left", 3, 1.0, 6.0) + bumps_under("b.right", 3, 1.5, 6.0)
    return simulate(robot, Truth(robot, floor=Floor(bumps=bumps), seed=3), free(1, 1))


@pytest.mark.parametrize("method", METHODS)
def test_the_trajectory_from_another_start_is_the_same_one_moved(drive, method):
    here, there = correct(drive, method=method), correct(drive, START, method=method)
    assert there.pose_a == pytest.approx(compose(START, here.pose_a), abs=1e-6)
    assert there.corrections == pytest.approx(here.corrections, abs=1e-6)


@pytest.mark.parametrize("method", METHODS[1:])
def test_truck_b_is_at_the_link_length_behind_truck_a_in_every_sample(drive, method):
    path = correct(drive, method=method)
    distance = np.hypot(*(path.pose_a - path.pose_b)[:, :2].T)
    assert distance == pytest.approx(drive.link_length(), abs=1e-9)


@pytest.mark.parametrize("method", METHODS)
def test_a_robot_that_stands_stays_at_its_start(drive, method):
    counts = np.repeat(drive.counts[:1], 50, axis=0)
    still = Recording(drive.vehicle, drive.time[:50], counts, np.ones((50, 7), bool))
    path = correct(still, START, method=method)
    assert path.pose_a == pytest.approx(np.tile(START, (50, 1)), abs=1e-12)
    assert np.ptp(path.pose_b, axis=0) == pytest.approx([0.0] * 3, abs=1e-12)
