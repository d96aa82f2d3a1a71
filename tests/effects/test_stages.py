"""The order of the signal path: what acts at which stage, and what a replay makes of a whole drive."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from omnimate.effects import EFFECTS, effect_named
from omnimate.effects.ageing import Younger
from omnimate.effects.effect import STAGES
from omnimate.effects.stages import by_stage, replay

ALL = [kind(component) for kind in EFFECTS for component in kind.components]
CHANGED = ("travel", "twist", "reading")

DIFFERENT = (
    effect_named("count_loss")("a.left", fraction=0.02, above=0.1),
    effect_named("wheel_diameter")("a.left", ratio=1.01),
    effect_named("wheelbase")("a", ratio=0.99),
    effect_named("joint_bias")("joint_a", bias=0.01),
    effect_named("latency")("poses", delay=0.1),
)


@given(st.lists(st.sampled_from(ALL), max_size=10))
def test_every_effect_acts_at_one_stage_and_those_of_a_stage_keep_their_order(effects):
    staged = by_stage(effects)
    assert tuple(staged) == STAGES
    assert sum(map(len, staged.values())) == len(effects)
    for stage, acting in staged.items():
        assert list(acting) == [effect for effect in effects if effect.acts_at() == stage]


def test_samples_of_a_wheel_age_at_the_encoder_and_those_of_poses_outside():
    latency = effect_named("latency")
    stages = [latency(component).acts_at() for component in ("a.left", "joint_a", "link", "poses")]
    assert stages == ["encoder", "reading", "reading", "poses"]


def test_younger_samples_are_those_of_as_much_later_a_time(block):
    for component, signal, column in (
        ("joint_a", "reading", 0),
        ("link", "reading", 2),
        ("a.left", "travel", 0),
    ):
        older = effect_named("latency")(component, delay=0.03)  # two periods
        early, late = (
            getattr(replay(block, [each]), signal)[:, column] for each in (Younger(component, older), older)
        )
        inside = slice(4, -4)
        shift = -2 if signal == "travel" else 2  # a wheel's true travel is before an old count of it
        np.testing.assert_allclose(
            np.roll(late, -shift)[inside], getattr(block, signal)[inside, column], atol=1e-12
        )
        np.testing.assert_allclose(
            np.roll(early, shift)[inside], getattr(block, signal)[inside, column], atol=1e-12
        )


@given(order=st.permutations(DIFFERENT))
def test_the_order_of_effects_of_different_stages_does_not_matter(block, order):
    first, second = replay(block, DIFFERENT), replay(block, order)
    assert all(np.array_equal(getattr(first, name), getattr(second, name)) for name in CHANGED)


def test_a_replay_without_effects_rolls_the_wheels_and_changes_nothing_else(block):
    replayed = replay(block, ())
    assert np.array_equal(replayed.travel, block.travel)
    assert np.array_equal(replayed.reading, block.reading)
    assert np.array_equal(replayed.twist, block.rolled().twist)


def test_counts_that_were_lost_are_given_back_before_the_wheels_travel(block):
    loss, diameter = DIFFERENT[:2]
    both = replay(block, (diameter, loss)).travel[:, 0]
    assert np.allclose(both, diameter.ratio * loss.recover(block).travel[:, 0], rtol=1e-12)
