"""Invariances of the calibration from absolute poses: the frame, the clock, left and right, passes."""

from dataclasses import replace

import numpy as np
import pytest

from omnimate.calib.paths.drives import drives_of
from omnimate.calib.paths.kinematics import Differential
from omnimate.calib.paths.least_squares import calibrate_path
from omnimate.motion.paths import umbmark
from omnimate.vcan_sim.reference import reference_single
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth, with_errors
from omnimate.vehicle.parameters import Truck
from omnimate.vehicle.se2 import compose

NOMINAL = Truck(0.340, 0.150, 0.152)


@pytest.fixture(scope="module")
def drive():
    """A UMBmark of a robot with wrong wheelbase and wheels, with fixes at the stops."""
    robot = reference_single()
    true = with_errors(robot, {"a": 0.98}, {"a": 1.002})
    return drives_of([simulate(robot, Truth(true, seed=4), umbmark(2.0, 2))])[0]


@pytest.fixture(scope="module")
def calibrated(drive):
    """The calibration from this drive."""
    return calibrate(drive)


def calibrate(*drives, kinematics=Differential(NOMINAL)):  # noqa: B008  # it is never changed
    """Return the calibration of wheelbase and ratio; without a tape, the mean diameter is held."""
    return calibrate_path(drives, kinematics, hold=["mean diameter (E_s)"])


def check_same(found, expected, signs=(1.0, 1.0, 1.0)):
    """Compare estimates in standard deviations, of which the search stops within a few hundredths."""
    atol = 0.05 * expected.sigma[[0, 2]].min()
    np.testing.assert_allclose(found.coordinates, expected.coordinates * np.array(signs), rtol=0.0, atol=atol)


@pytest.mark.parametrize("frame", [(0.0, 0.0, 1.3), (250.0, -40.0, 0.0), (-3.0, 7.0, -2.9)])
def test_the_frame_of_the_absolute_poses_does_not_matter(drive, calibrated, frame):
    moved = replace(drive, pose=compose(np.array(frame), drive.pose))
    check_same(calibrate(moved).estimate, calibrated.estimate)


@pytest.mark.parametrize("shift", [-100.0, 1e6])
def test_the_beginning_of_the_clock_does_not_matter(drive, calibrated, shift):
    later = replace(drive, time=drive.time + shift, fix_time=drive.fix_time + shift)
    check_same(calibrate(later).estimate, calibrated.estimate)


def test_a_mirrored_drive_exchanges_the_wheels(drive, calibrated):
    """Left and right, y and theta change sign: the wheelbase stays, the ratio of diameters is inverted."""
    mirror = np.array([1.0, -1.0, -1.0])
    mirrored = replace(drive, readings=drive.readings[:, ::-1], pose=drive.pose * mirror)
    exchanged = Truck(NOMINAL.wheelbase, NOMINAL.wheel_diameter_right, NOMINAL.wheel_diameter_left)
    found = calibrate(mirrored, kinematics=Differential(exchanged)).estimate
    check_same(found, calibrated.estimate, signs=(1.0, 1.0, -1.0))


def test_the_same_drive_given_twice_changes_no_parameter_and_makes_them_more_certain(drive, calibrated):
    alone, twice = calibrated.estimate, calibrate(drive, drive).estimate
    np.testing.assert_allclose(twice.coordinates, alone.coordinates, atol=0.1 * alone.sigma.max())
    assert (twice.sigma[[0, 2]] < alone.sigma[[0, 2]]).all()


def test_a_second_pass_finds_nothing_more(drive, calibrated):
    """The factors of both passes multiply, and the second ones are 1."""
    first = calibrated
    second = calibrate(drive, kinematics=first.kinematics)
    np.testing.assert_allclose(second.estimate.coordinates, 0.0, atol=2e-2 * first.estimate.sigma.max())
    assert second.truck.wheelbase / NOMINAL.wheelbase == pytest.approx(
        np.exp(first.estimate.coordinates[0] + second.estimate.coordinates[0]), rel=1e-12
    )
