"""The vocabulary: it names the effects of the project, and is consistent in itself."""

import pytest

from omnimate.effects import EFFECTS, effect_named
from studies.mismatch.engines.vocabulary import ALIKE, SIGNED, UNITS, UNNAMED, VOCABULARY

TARGETS = {"a.left", "a.right", "b.left", "b.right", "a", "b", "joint_a", "joint_b", "link"}


def test_the_vocabulary_holds_every_effect_of_the_simulator():
    assert set(VOCABULARY) == {effect.name for effect in EFFECTS if effect.searched}


@pytest.mark.parametrize("effect", VOCABULARY)
def test_an_effect_is_concealed_only_where_the_simulator_has_it(effect):
    assert VOCABULARY[effect].components
    assert set(VOCABULARY[effect].components) <= set(effect_named(effect).components) & TARGETS


@pytest.mark.parametrize("effect", VOCABULARY)
def test_an_effect_has_one_size_with_bounds_in_order_and_a_unit(effect):
    low, high = VOCABULARY[effect].concealed
    assert 0.0 < low < high
    assert VOCABULARY[effect].unit
    assert VOCABULARY[effect].parameter not in UNITS


@pytest.mark.parametrize("effect", VOCABULARY)
def test_effects_that_look_alike_are_others_of_the_vocabulary(effect):
    assert set(ALIKE[effect]) <= set(VOCABULARY) - {effect}


def test_a_size_is_a_ratio_or_signed_but_not_both():
    assert set(VOCABULARY) >= SIGNED
    assert all(VOCABULARY[effect].parameter != "ratio" for effect in SIGNED)


def test_physics_without_a_name_has_no_name_of_the_vocabulary():
    assert not set(UNNAMED) & set(VOCABULARY)
    assert all(places for places in UNNAMED.values())
