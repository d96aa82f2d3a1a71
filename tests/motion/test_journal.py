"""What is kept of a program's laps and fixes."""

import math

import numpy as np
import pytest

from omnimate.motion.journal import Journal
from omnimate.motion.program import Program


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


class FakeRecorder:
    def __init__(self):
        self.calls = []

    def lap(self, *lap):
        self.calls.append(lap)

    def pose(self, *pose):
        self.calls.append(pose)


def test_a_recorder_receives_each_lap_and_each_fix_at_once_and_in_order():
    recorder, runner = FakeRecorder(), FakeRunner()
    journal = Journal(Program("umbmark", (), ("cw",), 4.0), recorder)
    journal.fix(0.5, "a", np.zeros(3), np.ones(3))
    for time, lap in enumerate([None, 0, None]):
        runner.lap = lap
        journal.observe(float(time), runner)
        expected = 2 if time == 2 else 1
        assert len(recorder.calls) == expected
    journal.fix(2.0, "b", (0.1, 0.2, 0.3), (0.01, 0.01, 0.02))
    assert recorder.calls == [
        (0.5, "a", [0.0, 0.0, 0.0], [1.0, 1.0, 1.0]),
        ("cw", 1.0, 2.0),
        (2.0, "b", [0.1, 0.2, 0.3], [0.01, 0.01, 0.02]),
    ]
