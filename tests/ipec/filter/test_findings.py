"""What the filter says of a robot: a wrong joint is named, and a healthy robot is not suspected."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.effects.joint_backlash import JointBacklash
from omnimate.effects.joint_eccentricity import JointEccentricity
from omnimate.effects.latency import Latency
from omnimate.effects.link_eccentricity import LinkEccentricity
from omnimate.effects.traction_slip import TractionSlip
from omnimate.ipec.filter.estimate import estimate
from omnimate.ipec.filter.findings import MIN_LOST_TRAVEL, find_disturbances, findings
from omnimate.ipec.filter.live import Filter
from omnimate.ipec.filter.prior import SUSPECT_NAMES
from omnimate.motion.paths import rounded_rectangle
from omnimate.vcan_sim.biases import linkage_biases
from omnimate.vcan_sim.floor import Floor
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth, with_errors
from omnimate.vehicle.parameters import WHEELS
from omnimate.vehicle.se2 import between


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
    nothing = Filter(robot).start()
    untold = findings(Filter(robot).settings, nothing.record, nothing.filters).untold
    assert set(untold) == {
        name for name in SUSPECT_NAMES if not name.startswith(("diameter", "both")) and "both" not in name
    }


@pytest.mark.parametrize(
    ("effect", "name"),
    [
        (JointEccentricity("joint_a", np.radians(0.7), 0.8), "joint_a"),
        (LinkEccentricity("link", 0.006, 2.0), "link"),
        (Latency("a.left", 0.03), "a.left"),
        (TractionSlip("a.right", 0.1), "a.right"),
    ],
    ids=["joint off its centre", "pivot off its centre", "late wheel", "slip of a wheel"],
)
def test_an_error_of_a_known_form_is_named_and_the_pose_is_within_its_uncertainty(robot, effect, name):
    truth = Truth(robot, effects=(effect,), floor=Floor(), seed=3)
    recording = simulate(robot, truth, rounded_rectangle(6.0, 3.25, ["ccw", "cw"]))
    result = estimate(recording)
    assert [each for each, _ in result.findings.misread] == [name]
    true = recording.poses.of("a").pose
    error = between(true[0], true[-1]) - between(result.pose_a[0], result.pose_a[-1])
    assert np.all(np.abs(error[:2]) < 3.0 * result.sigma_a[-1, :2])


tables = st.integers(1, 60).flatmap(
    lambda count: st.tuples(st.just(count), st.integers(0, 2**32 - 1), st.sampled_from([1e-4, 1e-3]))
)


@given(tables)
def test_stretches_and_losses_are_those_of_the_table(drawn):
    """A reported stretch is distrusted throughout and not beside it; no larger one is left out."""
    count, seed, size = drawn
    chance = np.random.default_rng(seed)
    alert = np.where(chance.random((count, 4)) < 0.5, 0.1, 0.0)
    lost = np.where(alert > 0.0, size * chance.random((count, 4)), 0.0)
    time = np.arange(float(count))
    reported = find_disturbances(time, alert, lost)
    for disturbance in reported:
        column = WHEELS.index(disturbance.wheel)
        first, last = int(disturbance.start), int(disturbance.end)
        assert (alert[first : last + 1, column] > 0.0).all()
        assert first == 0 or alert[first - 1, column] == 0.0
        assert last == count - 1 or alert[last + 1, column] == 0.0
        assert disturbance.lost == pytest.approx(lost[first : last + 1, column].sum())
        assert disturbance.lost >= MIN_LOST_TRAVEL
    assert [disturbance.start for disturbance in reported] == sorted(d.start for d in reported)
    left = lost.sum() - sum(disturbance.lost for disturbance in reported)
    stretches = (np.diff((alert > 0.0).astype(int), axis=0, prepend=0) > 0).sum()
    assert left <= MIN_LOST_TRAVEL * (stretches - len(reported)) + 1e-12
