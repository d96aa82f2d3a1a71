"""The vocabulary: it names the effects of the project, and is consistent in itself."""

import pytest

from omnimate.effects import EFFECTS, effect_named
from studies.mismatch.engines.vocabulary import ALIKE, RATIOS, SIGNED, SIZES, UNITS, UNNAMED, components

TARGETS = {"a.left", "a.right", "b.left", "b.right", "a", "b", "joint_a", "joint_b", "link"}


def test_the_vocabulary_holds_every_effect_of_the_simulator():
    assert set(SIZES) == {effect.name for effect in EFFECTS if effect.searched}


@pytest.mark.parametrize("effect", SIZES)
def test_an_effect_is_concealed_only_where_the_simulator_has_it(effect):
    assert components(effect)
    assert set(components(effect)) <= set(effect_named(effect).components) & TARGETS


@pytest.mark.parametrize("effect", SIZES)
def test_an_effect_has_one_size_with_bounds_in_order_and_a_unit(effect):
    ((name, (low, high)),) = SIZES[effect].items()
    assert 0.0 < low < high
    assert name in UNITS


@pytest.mark.parametrize("effect", SIZES)
def test_effects_that_look_alike_are_others_of_the_vocabulary(effect):
    assert set(ALIKE[effect]) <= set(SIZES) - {effect}


def test_a_size_is_a_ratio_or_signed_but_not_both():
    assert not RATIOS & SIGNED
    assert set(SIZES) >= RATIOS | SIGNED


def test_physics_without_a_name_has_no_name_of_the_vocabulary():
    assert not set(UNNAMED) & set(SIZES)
    assert all(places for places in UNNAMED.values())
