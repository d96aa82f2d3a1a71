"""The OmniMate's equations, O (1)-(6): as corrected; `studies.papers` has what they do as printed."""

import numpy as np
import pytest

from omnimate.ipec.corrector import correct
from omnimate.motion.paths import rounded_rectangle
from omnimate.vcan_sim.floor import SMOOTH
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth
from omnimate.vehicle.sonar import Sonar


@pytest.fixture
def turns(robot):
    """A car-like turn of 360 degrees in each direction, without any error."""
    truth = Truth(robot, floor=SMOOTH, sonar=Sonar(sigma=0.0))
    return simulate(robot, truth, rounded_rectangle(6.0, 3.25, ["cw", "ccw"]))


def test_corrected_it_stays_below_a_hundredth_of_a_degree_in_a_turn(turns, lap_errors):
    errors = lap_errors(turns, correct(turns, method="omnimate").pose_a)
    assert np.degrees(np.abs(errors[:, 2])).max() < 0.01
