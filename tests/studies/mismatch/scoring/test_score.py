"""The score: a perfect answer is perfect, a wrong one is counted wrong."""

import pytest

from studies.mismatch.scoring.judging import all_right, reported_instead
from studies.mismatch.scoring.score import rows, share

TRUTH = {
    "effect": "wheelbase", "component": "a", "intervals": [],
    "parameters": {"ratio": {"value": 1.01, "unit": "1"}},
    "acceptable": [{"effect": "turn_scrub", "component": "a"}],
}  # fmt: skip


def label(kind="single", *effects):
    return {"kind": kind, "effects": list(effects)}


def finding(effect="wheelbase", component="a", probability=0.95, value=1.0101):
    return {
        "effect": effect, "component": component, "probability": probability, "alternatives": [],
        "where": {"intervals": []}, "parameters": {"ratio": {"value": value, "sigma": 1e-4, "unit": "1"}},
    }  # fmt: skip


def answer(*findings, after=1.0):
    return {
        "verdict": "mismatch",
        "findings": list(findings),
        "fit": {"heldout": {"before": 2.0, "after": after}},
    }


def table(labels, answers):
    return {row.name: row for row in rows({"x": labels}, {"x": answers})}


def test_a_perfect_answer_is_perfect():
    found = table(label("single", TRUTH), answer(finding()))
    assert found["one effect: right first"].value == 1.0
    assert found["said 0.9 or more, and wrong"].value == 0.0
    assert found["parameter within 2 sigma"].value == 1.0
    assert found["95 % set holds the truth"].value == 1.0


def test_what_the_drive_cannot_tell_apart_is_right_but_not_exact():
    found = table(label("single", TRUTH), answer(finding("turn_scrub")))
    assert found["one effect: right first"].value == 1.0
    assert found["one effect: exactly the truth first"].value == 0.0


def test_a_wrong_name_is_counted_wrong():
    found = table(label("single", TRUTH), answer(finding("wheelbase", "b")))
    assert found["one effect: right first"].value == 0.0
    assert found["said 0.9 or more, and wrong"].value == 1.0


def test_silence_is_not_right():
    assert table(label("single", TRUTH), answer())["one effect: right first"].value == 0.0


def test_any_assertion_on_a_null_is_a_false_alarm():
    assert table(label("null"), answer(finding()))["false alarm on a null"].value == 1.0
    assert table(label("null"), answer(finding(probability=0.4)))["false alarm on a null"].value == 0.0


def test_a_parameter_far_off_its_sigma_is_counted():
    assert (
        table(label("single", TRUTH), answer(finding(value=1.011)))["parameter within 2 sigma"].value == 0.0
    )


def test_wilsons_interval_holds_the_share():
    row = share("x", [True] * 9 + [False], 0.95)
    assert row.interval == pytest.approx((0.596, 0.982), abs=1e-3)
    assert row.is_missed


def test_naming_what_is_true_beside_the_effects_is_right_and_missing_it_is_no_mistake():
    beside = {"effect": "lateral_slip", "component": "a"}
    two = {**label("multi", TRUTH, {**TRUTH, "component": "b"}), "secondary": [beside]}
    effects = finding(), finding(component="b")
    assert all_right(two, answer(*effects))
    assert all_right(two, answer(*effects, finding("lateral_slip")))
    assert not all_right(two, answer(*effects, finding("lateral_slip", "b")))
    assert table(two, answer(finding("lateral_slip")))["said 0.9 or more, and wrong"].value == 0.0


def test_what_counts_as_right_in_place_of_the_truth_is_reported():
    labels = {name: label("single", TRUTH) for name in ("exact", "alike", "wrong")}
    answers = {
        "exact": answer(finding()),
        "alike": answer(finding("turn_scrub")),
        "wrong": answer(finding("joint_bias", "joint_a")),
    }
    assert reported_instead(labels, answers) == {("wheelbase a", "turn_scrub a"): 1}
