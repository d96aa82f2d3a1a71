"""The first check of a recording is the plain difference between odometry and the poses."""

import math

import numpy as np
import pytest

from omnimate.files.importers.clock import recording_of
from omnimate.files.importers.sanity import odometry_error
from omnimate.files.importers.series import Series, poses_of

TIME = 0.02 * np.arange(101)


def driven(robot, left, right, pose):
    wheels = {
        wheel: Series(TIME, np.rint(np.linspace(0.0, end, 101)), "counts", "test")
        for wheel, end in (("a.left", left), ("a.right", right))
    }
    return recording_of(robot, wheels, "test", pose and poses_of("a", TIME[[0, -1]], np.array(pose, float)))


def test_a_turn_on_the_spot_beside_a_pose_that_stands_still(robot):
    seen = odometry_error(driven(robot, -100.0, 100.0, [[1, 2, 3], [1, 2, 3]]))
    turn = 0.1 * math.pi * (0.2 + 0.201) / 0.5 / 1.0
    assert seen.heading == pytest.approx(turn, rel=1e-9)
    assert seen.distance == pytest.approx(0.05 * math.pi * 0.001, rel=1e-6)


@pytest.mark.parametrize(("heading", "error"), [(math.pi / 2, 0.0), (0.0, 0.2 * math.pi * math.sqrt(2.0))])
def test_it_begins_at_the_first_pose_wherever_that_is(robot, heading, error):
    pose = [[5, 5, heading], [5, 5 + 0.2 * math.pi, heading]]
    seen = odometry_error(driven(robot, 1000.0, 1000.0, pose))
    assert seen.position == pytest.approx(error, abs=0.01)


@pytest.mark.parametrize("pose", [None, [[0, 0, math.nan], [1, 0, math.nan]]])
def test_without_headings_there_is_nothing_to_see(robot, pose):
    assert odometry_error(driven(robot, 10.0, 10.0, pose)) is None
