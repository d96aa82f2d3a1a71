"""What is kept of a program's laps and fixes."""

import math

import pytest

from motion.journal import Journal
from motion.program import Program


class FakeRunner:
    lap = None


def test_laps_begin_and_end_when_the_runner_says_so_and_an_unfinished_one_is_not_kept():
    journal, runner = Journal(Program("umbmark", (), ("cw", "ccw", "cw"), 4.0)), FakeRunner()
    for time, lap in enumerate([None, 0, 0, None, 1, 2, 2]):
        runner.lap = lap
        journal.observe(float(time), runner)
    run = journal.run
    assert (run.protocol, run.side) == ("umbmark", 4.0)
    assert [(lap.direction, lap.start, lap.end) for lap in run.laps] == [("cw", 1.0, 3.0), ("ccw", 4.0, 5.0)]


def test_fixes_become_poses_in_order_and_an_unknown_one_stays_unknown():
    journal = Journal(Program("free", (), ()))
    assert journal.poses is None
    journal.fix(1.0, "a", (0.1, 0.2, 0.3), (0.002, 0.002, 0.007))
    journal.fix(1.0, "b", (math.nan,) * 3, (math.nan,) * 3)
    poses = journal.poses
    assert poses.body.tolist() == ["a", "b"]
    assert poses.of("a").pose[0] == pytest.approx((0.1, 0.2, 0.3))
    assert math.isnan(poses.of("b").sigma[0, 0])
