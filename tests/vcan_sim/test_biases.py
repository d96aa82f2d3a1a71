"""Biases of the linkage: effects that the plant adds as shifts of the encoders' zeros."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.effects import effect_named
from omnimate.vcan_sim.biases import linkage_biases, split_biases
from omnimate.vcan_sim.plant import Plant
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.truth import Truth

ECCENTRIC = effect_named("joint_eccentricity")("joint_a", amplitude=0.02, phase=0.5)
HARMLESS = effect_named("joint_eccentricity")("joint_a", amplitude=0.0)
DIAMETER = effect_named("wheel_diameter")("a.left", ratio=1.01)

angles = st.floats(-0.1, 0.1)


@given(angles, angles, st.floats(-0.05, 0.05))
def test_biases_come_back_from_their_effects_and_leave_none(joint_a, joint_b, link):
    assert split_biases(linkage_biases(joint_a, joint_b, link)) == ((joint_a, joint_b, link), ())


def test_biases_of_the_same_encoder_add_up():
    total, left = split_biases((*linkage_biases(0.01), *linkage_biases(0.02)))
    assert total == pytest.approx((0.03, 0.0, 0.0))
    assert left == ()


def test_an_effect_of_another_stage_does_not_come_before_a_bias():
    total, left = split_biases((DIAMETER, *linkage_biases(0.01)))
    assert (total, left) == ((0.01, 0.0, 0.0), (DIAMETER,))


def test_a_bias_after_another_effect_on_the_readings_waits_for_its_turn():
    after = linkage_biases(0.3)
    assert split_biases((ECCENTRIC, *after)) == ((0.0, 0.0, 0.0), (ECCENTRIC, *after))
    assert split_biases((*after, ECCENTRIC)) == ((0.3, 0.0, 0.0), (ECCENTRIC,))


def test_a_robot_reads_the_same_whether_its_biases_are_shifts_or_effects():
    """A bias behind an effect that does nothing acts as an effect, a bias before it as a shift."""
    vehicle, biases = reference_vehicle(), linkage_biases(0.012, -0.007, 0.003)
    shifted, acting = (
        Plant(Truth(vehicle, effects=effects), vehicle)
        for effects in ((*biases, HARMLESS), (HARMLESS, *biases))
    )
    for command in 3.0 + np.sin(np.outer(np.arange(300), [0.01, 0.013, 0.008, 0.011])):
        for plant in (shifted, acting):
            plant.step(command, 0.015)
        assert shifted.raw_counts() == acting.raw_counts()


def test_an_encoder_without_bias_needs_no_effect():
    assert [effect.component for effect in linkage_biases(joint_b=0.01)] == ["joint_b"]
