"""What the filter says of a robot: a wrong joint is named, and a healthy robot is not suspected."""

import numpy as np
import pytest

from omnimate.ipec.filter.estimate import estimate
from omnimate.ipec.filter.findings import findings
from omnimate.ipec.filter.live import Filter
from omnimate.ipec.filter.prior import SUSPECTED
from omnimate.motion.paths import rounded_rectangle
from omnimate.vcan_sim.biases import linkage_biases
from omnimate.vcan_sim.effects.joint_backlash import JointBacklash
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth, with_errors


def drive(robot, truth):
    return estimate(simulate(robot, truth, rounded_rectangle(6.0, 3.25, ["ccw", "cw"])))


def test_a_healthy_robot_is_not_suspected(robot):
    said = drive(robot, Truth(robot, seed=3)).findings
    assert said.suspects == ()
    assert said.misread == ()
    assert said.scatter == ()


def test_a_joint_that_reads_half_a_degree_too_much_is_named_with_its_bias(robot):
    result = drive(robot, Truth(robot, effects=linkage_biases(joint_a=np.radians(0.5)), seed=3))
    assert [name for name, _ in result.findings.suspects] == ["bias of joint_a"]
    assert np.degrees(result.slow.joint_bias[0]) == pytest.approx(0.5, abs=0.05)


def test_a_wheel_that_is_a_percent_larger_is_known_by_its_ratio(robot):
    result = drive(robot, Truth(with_errors(robot, {}, {"b": 1.01}), seed=3))
    assert result.slow.wheel[3] - result.slow.wheel[2] == pytest.approx(0.01, abs=0.001)
    assert all(" b" in f" {name[-8:]}" for name, _ in result.findings.suspects)


def test_a_joint_with_play_is_named_and_the_wheels_are_believed_instead(robot):
    truth = Truth(robot, effects=(JointBacklash("joint_b", np.radians(2.0)),), seed=3)
    said = drive(robot, truth).findings
    assert [name for name, _ in said.misread] == ["joint_b"]


def test_a_drive_tells_what_its_bends_move_and_a_robot_that_stands_tells_nothing(robot):
    assert drive(robot, Truth(robot, seed=3)).findings.untold == ()
    nothing = Filter(robot).start().record
    untold = findings(Filter(robot).settings, nothing).untold
    assert set(untold) == {name for name in SUSPECTED if not name.startswith(("diameter", "both"))}
