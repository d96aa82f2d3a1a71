"""The growth-rate concept of C 3.3 in numbers, and driven over a bump."""

import numpy as np
import pytest

from omnimate.effects.crossing import chord_loss
from omnimate.ipec.corrector import correct
from omnimate.ipec.errors import NoLinkageError
from omnimate.vcan_sim.reference import reference_single
from studies.papers.bumps import bump_drive, bump_errors, bump_growth
from studies.papers.robots import fine


def test_plain_odometry_errs_by_0_44_degrees_at_once_and_0_15_mm_in_each_interval():
    growth = bump_growth()
    assert np.degrees(-growth.plain[1:, 0]) == pytest.approx(0.443, abs=0.002)
    assert -1e3 * np.diff(growth.plain[2:, 1]) == pytest.approx(0.155, abs=0.005)


def test_the_linkage_sees_at_least_what_the_paper_bounds_and_ipec_removes_it():
    growth = bump_growth()
    assert np.degrees(-growth.seen[1]) == pytest.approx(np.degrees(growth.printed.measured), abs=0.01)
    assert np.degrees(np.abs(growth.ipec[:, 0])).max() < 0.01
    assert np.abs(growth.ipec[:, 1]).max() < 0.2e-3


def test_after_a_bump_the_lateral_error_grows_with_the_way_to_its_end_and_ipec_leaves_half_a_millimetre():
    robot = fine()
    lost = chord_loss(0.075, 0.010)
    drive = bump_drive(robot, lost)
    errors = bump_errors(lost, 0.340, 0.5 * robot.bus.sync_period, 1.0)
    plain, path = (
        correct(drive.recording, drive.pose_a[0], method=method).pose_a - drive.pose_a
        for method in ("plain", "clapper")
    )
    past = drive.way > 0.55
    assert np.abs(plain[past, 2]) == pytest.approx(errors.heading, rel=1e-3)
    assert abs(plain[-1, 1] - plain[past, 1][0]) == pytest.approx(
        errors.lateral * (drive.way[-1] - drive.way[past][0]), rel=0.01
    )
    assert np.degrees(np.abs(path[:, 2]).max()) < 0.015  # C (7) allows 0.01 for each truck
    assert np.abs(path[:, 1]).max() < 0.0005


def test_a_bump_drive_needs_a_linkage():
    with pytest.raises(NoLinkageError):
        bump_drive(reference_single(), 0.003)
