"""Data held out: stretches in which nothing was measured are stretches, too."""

import numpy as np

from omnimate.files.importers.robots import single_truck
from omnimate.mismatch import diagnose
from omnimate.vehicle.parameters import Truck
from omnimate.vehicle.recording import Poses, Recording

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
