"""The OmniMate's equations, O (1)-(6): right when corrected, and failing as NOTES says when printed."""

import numpy as np
import pytest

from omnimate.ipec.corrector import correct
from omnimate.motion.paths import rounded_rectangle
from omnimate.vcan_sim.floor import SMOOTH
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth
from omnimate.vehicle.sonar import Sonar
from studies.papers.bump_drive import bump_drive


@pytest.fixture
def turns(robot):
    """A car-like turn of 360 degrees in each direction, without any error."""
    truth = Truth(robot, floor=SMOOTH, sonar=Sonar(sigma=0.0))
    return simulate(robot, truth, rounded_rectangle(6.0, 3.25, ["cw", "ccw"]))


def test_corrected_it_stays_below_a_hundredth_of_a_degree_in_a_turn(turns, lap_errors):
    errors = lap_errors(turns, correct(turns, method="omnimate").pose_a)
    assert np.degrees(np.abs(errors[:, 2])).max() < 0.01


def test_with_the_previous_position_of_b_it_errs_by_10_to_50_degrees_per_turn(turns, lap_errors):
    errors = np.degrees(lap_errors(turns, correct(turns, method="omnimate-previous-b").pose_a)[:, 2])
    assert np.all((np.abs(errors) > 10.0) & (np.abs(errors) < 50.0))


def test_the_printed_sign_doubles_an_error_at_every_sample(fine):
    drive = bump_drive(fine, 1e-4, after=0.1)
    path = correct(drive.recording, drive.pose_a[0], method="omnimate-printed-sign")
    error = np.abs(path.pose_a[:, 2] - drive.pose_a[:, 2])
    grown = error[(error > 1e-3) & (error < 0.5)]
    assert len(grown) > 5
    assert grown[1:] / grown[:-1] == pytest.approx(2.0, abs=0.1)
