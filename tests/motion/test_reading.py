"""What the linkage reads."""

import math

import pytest

from omnimate.motion.reading import LinkReader


def test_a_robot_with_two_trucks_reads_angles_and_length(two_trucks):
    link = LinkReader(two_trucks).read((5, 6, 7, 8, 4096, -8192, 250))
    assert link == pytest.approx((math.pi / 2.0, -math.pi, 1.025))


def test_a_single_truck_reads_nothing(one_truck):
    assert LinkReader(one_truck).read((5, 6)) is None
