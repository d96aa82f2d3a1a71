"""What the filter has learned goes into `vehicle.toml` only where the encoders have decided it."""

import numpy as np
import pytest

from omnimate.calib.linkage.learned import advice_of, learned_vehicle
from omnimate.ipec.filter.findings import Findings, SlowParameters
from omnimate.vcan_sim.reference import reference_vehicle

ROBOT = reference_vehicle()
SLOW = SlowParameters(
    np.array([-0.002, 0.002, -0.001, 0.001]),
    np.array([0.01, -0.01]),
    np.zeros(2),
    np.radians([0.2, -0.4]),
    0.003,
    np.full(11, 1e-4),
)


def found(*undecided):
    return Findings((), tuple((name, 0.5) for name in undecided), (), (), ())


def test_a_value_that_is_undecided_stays_and_all_others_are_taken_over():
    learned = learned_vehicle(ROBOT, SLOW, found("diameters of b", "wheelbase of a"))
    truck_a, truck_b = learned.trucks["a"], learned.trucks["b"]
    assert truck_a.wheel_diameter_left == pytest.approx(ROBOT.trucks["a"].wheel_diameter_left * 0.998)
    assert truck_a.wheelbase == ROBOT.trucks["a"].wheelbase
    assert truck_b.wheel_diameter_left == ROBOT.trucks["b"].wheel_diameter_left
    assert truck_b.wheelbase == pytest.approx(ROBOT.trucks["b"].wheelbase * 0.99)


def test_a_joint_bias_that_is_undecided_leaves_the_zero_of_that_joint_alone():
    both, kept = (learned_vehicle(ROBOT, SLOW, found(*names)) for names in ((), ("bias of joint_b",)))
    assert kept.encoder("joint_a") == both.encoder("joint_a") != ROBOT.encoder("joint_a")
    assert kept.encoder("joint_b") == ROBOT.encoder("joint_b") != both.encoder("joint_b")


def test_rivals_are_named_together_and_one_of_them_is_not_said_to_be_wrong():
    findings = Findings(
        (("bias of joint_b", 0.6),), (("diameters of a", 0.4), ("bias of joint_b", 0.6)), (), (), ()
    )
    texts = [advice.what for advice in advice_of(findings)]
    assert any("diameters of a (0.40), bias of joint_b (0.60)" in text for text in texts)
    assert not any("probably wrong" in text for text in texts)
