"""The vocabulary: it names the effects of the project, is consistent in itself, and makes labels."""

import pytest

from omnimate.effects import EFFECTS, effect_named
from studies.mismatch.engines.vocabulary import ALIKE, SIGNED, UNITS, UNNAMED, VOCABULARY, label

TARGETS = {"a.left", "a.right", "b.left", "b.right", "a", "b", "joint_a", "joint_b", "link"}


def test_the_vocabulary_holds_every_effect_of_the_simulator_and_nothing_without_a_name():
    assert set(VOCABULARY) == {effect.name for effect in EFFECTS if effect.searched}
    assert not set(UNNAMED) & set(VOCABULARY)
    assert all(places for places in UNNAMED.values())


@pytest.mark.parametrize("effect", VOCABULARY)
def test_an_effect_has_components_bounds_a_unit_and_look_alikes_of_the_vocabulary(effect):
    own = VOCABULARY[effect]
    assert own.components
    assert set(own.components) <= set(effect_named(effect).components) & TARGETS
    assert 0.0 < own.concealed[0] < own.concealed[1]
    assert own.unit
    assert own.parameter not in UNITS
    assert set(ALIKE[effect]) <= set(VOCABULARY) - {effect}


def test_a_size_is_a_ratio_or_signed_but_not_both():
    assert set(VOCABULARY) >= SIGNED
    assert all(VOCABULARY[effect].parameter != "ratio" for effect in SIGNED)


@pytest.mark.parametrize("effect", VOCABULARY)
def test_acceptable_effects_are_alike_by_judgement_and_act_where_they_can(effect):
    for component in VOCABULARY[effect].components:
        others = label(effect, component, {"times": []})["acceptable"]
        acceptable = [(other["effect"], other["component"]) for other in others]
        assert (effect, component) not in acceptable
        assert len(set(acceptable)) == len(acceptable)
        assert all(other["by_judgement"] for other in others)
        assert all(name in ALIKE[effect] for name, _ in acceptable)
        assert all(place in VOCABULARY[name].components for name, place in acceptable)


def test_a_label_has_values_with_units_and_the_intervals_of_events():
    bumps = label("bump", "a.left", {"times": [1.0, 5.0], "lost": [0.002, 0.002]})
    assert [start for start, _ in bumps["intervals"]] == [1.0, 5.0]
    assert all(end > start for start, end in bumps["intervals"])
    patch = label("slip_patch", "a.left", {"fraction": 0.05, "intervals": [[2.0, 9.0]]})
    assert patch["parameters"] == {"fraction": {"value": 0.05, "unit": "1"}}
    assert patch["intervals"] == [[2.0, 9.0]]
    assert label("unknown", "a", {"kind": "pushes", "size": 0.02, "times": []})["parameters"] == {}
