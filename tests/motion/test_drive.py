"""A moment of a drive, and what the linkage reads."""

import math
from itertools import pairwise

import numpy as np
import pytest

from omnimate.motion.drive import LinkReader, Moment, drive
from omnimate.motion.journal import Journal
from omnimate.motion.paths import squares
from omnimate.motion.runner import Runner
from omnimate.vehicle.odometry import Odometer
from omnimate.vehicle.sample import Sample


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


class ObedientRobot:
    """Its wheels turn as commanded; each sample comes one SYNC period after the one before."""

    def __init__(self, vehicle):
        self._period, self._index = vehicle.bus.sync_period, -1
        diameters = vehicle.trucks["a"].wheel_diameter_left, vehicle.trucks["a"].wheel_diameter_right
        self._counts_per_radian = [
            diameter / 2.0 / vehicle.metres_per_count(wheel)
            for diameter, wheel in zip(diameters, vehicle.wheels, strict=True)
        ]
        self._angles, self._speeds = np.zeros(2), np.zeros(2)

    def cycle(self):
        self._index += 1
        self._angles += self._speeds * self._period
        counts = tuple(np.rint(self._angles * self._counts_per_radian).astype(int).tolist())
        return Sample(self._index, self._index * self._period, counts, (True, True), (0.0, 0.0), (0.0, 0.0))

    def command(self, wheel_speeds):
        self._speeds = np.array(wheel_speeds)


@pytest.mark.parametrize("fix", [None, lambda _truck: (np.array([0.02, -0.01, 0.03]), np.full(3, 0.01))])
def test_odometry_of_the_caller_gives_the_same_drive_wherever_it_started(one_truck, fix):
    program = squares(["ccw"], 0.4, speed=0.4, link_length=None, home_first=fix is not None)

    def driven(locate):
        runner = Runner(program, one_truck)
        return list(drive(ObedientRobot(one_truck), runner, one_truck, Journal(program), fix, locate))

    own, shared = driven(None), driven(Odometer(one_truck, "a", (5.0, -3.0, 2.0)).step)
    after_fix = [moment.pose for before, moment in pairwise(own) if before.fix is not None]
    assert len(after_fix) == (0 if fix is None else 3)
    np.testing.assert_allclose(after_fix, [(0.02, -0.01, 0.03)] * len(after_fix), atol=0.01)
    assert [moment.lap for moment in shared] == [moment.lap for moment in own]
    np.testing.assert_allclose([moment.pose for moment in shared], [moment.pose for moment in own], atol=1e-3)
