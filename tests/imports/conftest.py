"""Robots and recordings that the importers are tried on."""

import numpy as np
import pytest

from imports.clock import recording_of
from imports.poses import poses_of
from imports.robots import single_truck
from imports.series import Series
from vehicle.parameters import Truck


@pytest.fixture
def robot():
    """A differential drive with slightly unequal wheels, 1000 counts per turn."""
    return single_truck("tried", Truck(0.5, 0.2, 0.201), 1000.0, 0.02)


@pytest.fixture
def drive(robot):
    """Four seconds of a bend at 50 Hz, with poses at every fifth sample, on an epoch clock."""
    time = 1_700_000_000.0 + 0.02 * np.arange(200)
    steps = np.arange(200)
    left, right = (Series(time, speed * steps, "counts", "test") for speed in (3.0, 4.0))
    pose = np.column_stack((0.002 * steps, 0.001 * steps, 0.05 * steps))[::5]
    return recording_of(robot, {"a.left": left, "a.right": right}, "test", poses_of("a", time[::5], pose))
