"""Dead reckoning of a reference that does not sit where the robot's pose is."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omnimate.calib.paths.drives import Drive
from omnimate.calib.paths.kinematics import Differential
from omnimate.calib.paths.reference import dead_reckoned
from omnimate.vehicle.parameters import Truck
from omnimate.vehicle.se2 import compose

TRUCK = Truck(0.34, 0.15, 0.15)
SMALL = st.floats(-0.2, 0.2)


@settings(max_examples=25)
@given(seed=st.integers(0, 1000), x=SMALL, y=SMALL, yaw=SMALL)
def test_a_perfect_robot_shows_its_reference_where_it_was_measured(seed, x, y, yaw):
    chance, lever, kinematics = np.random.default_rng(seed), np.array([x, y, yaw]), Differential(TRUCK)
    time, readings = np.arange(50) * 0.1, np.cumsum(chance.uniform(0.0, 0.5, (50, 2)), axis=0)
    unknown = np.full((50, 3), np.nan)
    axle = dead_reckoned(Drive(time, readings, time, np.zeros((50, 3)), unknown, "axle"), kinematics)
    measured = Drive(time, readings, time, compose(axle, lever), unknown, "markers")
    assert dead_reckoned(measured, kinematics, lever) == pytest.approx(measured.pose, abs=1e-9)
