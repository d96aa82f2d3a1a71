"""The labels: parameters with units, the intervals of events, and acceptable names where a drive has them."""

import pytest

from studies.mismatch.engines.vocabulary import ALIKE, VOCABULARY, label

PLACES = [(effect, component) for effect in VOCABULARY for component in VOCABULARY[effect].components]


@pytest.mark.parametrize(("effect", "component"), PLACES)
def test_acceptable_effects_are_alike_and_act_where_they_can(effect, component):
    acceptable = [
        (other["effect"], other["component"])
        for other in label(effect, component, {"times": []})["acceptable"]
    ]
    assert (effect, component) not in acceptable
    assert len(set(acceptable)) == len(acceptable)
    assert all(
        other in ALIKE[effect] and place in VOCABULARY[other].components for other, place in acceptable
    )


@pytest.mark.parametrize(("effect", "component"), PLACES)
def test_acceptable_effects_are_said_to_be_so_by_judgement(effect, component):
    assert all(other["by_judgement"] for other in label(effect, component, {"times": []})["acceptable"])


def test_a_bump_has_an_interval_for_each_event():
    made = label("bump", "a.left", {"times": [1.0, 5.0], "lost": [0.002, 0.002]})
    assert [start for start, _ in made["intervals"]] == [1.0, 5.0]
    assert all(end > start for start, end in made["intervals"])


def test_a_parameter_has_its_value_and_its_unit():
    made = label("slip_patch", "a.left", {"fraction": 0.05, "intervals": [[2.0, 9.0]]})
    assert made["parameters"] == {"fraction": {"value": 0.05, "unit": "1"}}
    assert made["intervals"] == [[2.0, 9.0]]


def test_physics_without_a_name_has_no_parameters_to_estimate():
    assert label("unknown", "a", {"kind": "pushes", "size": 0.02, "times": []})["parameters"] == {}
