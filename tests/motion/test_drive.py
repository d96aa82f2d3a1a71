"""A moment of a drive, and what the linkage reads."""

import math

import numpy as np
import pytest

from omnimate.motion.drive import Moment
from omnimate.motion.reading import LinkReader


def test_the_error_is_absolute_minus_calculated_with_the_heading_wrapped():
    moment = Moment(None, (1.0, 2.0, math.pi - 0.1), None, np.array([1.5, 1.0, -math.pi + 0.1]))
    assert moment.error == pytest.approx((0.5, -1.0, 0.2))


def test_without_a_fix_there_is_no_error():
    assert Moment(None, (1.0, 2.0, 0.0), 0).error is None


def test_a_robot_with_two_trucks_reads_angles_and_length(two_trucks):
    link = LinkReader(two_trucks).read((5, 6, 7, 8, 4096, -8192, 250))
    assert link == pytest.approx((math.pi / 2.0, -math.pi, 1.025))


def test_a_single_truck_reads_nothing(one_truck):
    assert LinkReader(one_truck).read((5, 6)) is None
