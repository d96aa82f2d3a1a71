"""The drives are those of the papers, and the terms of the error budget can be switched off one by one."""

import math

import numpy as np
import pytest

from studies.papers.protocols import CLAPPER_SONAR, as_derived, measured, return_errors, straight_errors
from studies.papers.robots import TERMS, calibrated_truth, clapper, laps, rectangle, straight


def test_the_straight_line_goes_18_m_out_and_back_three_times():
    drive = straight(0, 0)
    assert len(drive.run.laps) == 3
    assert 0.075 * np.ptp(drive.wheel_angle("a.left")) == pytest.approx(
        18.0, abs=0.3
    )  # and the way home between runs


def test_the_rectangle_starts_and_ends_at_its_corner():
    drive = rectangle(0, "ccw", 1, 0)
    x, y = as_derived(drive, drive.poses.of("a").pose[0], "clapper")[:, :2].T
    assert x.min() == pytest.approx(-1.0, abs=0.3)
    assert x.max() == pytest.approx(6.0, abs=0.3)
    assert y.max() == pytest.approx(4.0, abs=0.3)


@pytest.mark.parametrize("way", ["cw", "ccw"])
def test_a_lap_of_the_omnimate_is_about_18_m_long(way):
    drive = laps(0, way)
    before, after = (drive.run.laps[0].start, drive.run.laps[0].end)
    inside = (drive.time >= before) & (drive.time <= after)
    mean = 0.075 * 0.5 * (drive.wheel_angle("a.left") + drive.wheel_angle("a.right"))[inside]
    assert np.abs(np.diff(mean)).sum() == pytest.approx(18.0, abs=1.0)


def test_the_sonar_stays_within_the_bounds_that_the_paper_gives():
    drive = straight(0, 0)
    off = measured(drive, CLAPPER_SONAR, 1).pose - drive.poses.of("a").pose
    assert (np.abs(off) <= CLAPPER_SONAR).all()
    assert measured(drive, CLAPPER_SONAR, 1).sigma[0, 2] == pytest.approx(math.radians(0.25) / math.sqrt(3.0))


def test_each_term_of_the_budget_changes_the_result_alone():
    whole = straight_errors(0, 0)["CLAPPER"]
    for term in TERMS[1:]:
        without = straight_errors(0, 0, term)["CLAPPER"]
        assert not np.allclose(without, whole, rtol=0.0, atol=1e-12), term


def test_a_switched_off_calibration_error_leaves_the_others_as_they_were():
    whole, without = (calibrated_truth(clapper(), (), 3, term) for term in ("nothing", "joint bias"))
    assert [bias.component for bias in whole.effects] == ["joint_a", "joint_b", "link"]
    assert without.effects == whole.effects[2:]
    assert without.vehicle == whole.vehicle


def test_plain_odometry_turns_at_every_bump_and_the_correction_does_not():
    errors = return_errors(straight(1, 10), CLAPPER_SONAR, 1)
    plain, ours = (np.degrees(np.abs(errors[name][:, 2])).mean() for name in ("plain", "CLAPPER"))
    assert 4.0 < plain < 8.0
    assert ours < 0.25 * plain
