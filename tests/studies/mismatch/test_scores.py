"""Scores of worlds: one for each, one for those that others made, as objects and as a figure."""

import json

import pytest

from studies.figures import plot_reliability
from studies.mismatch.scoring.score import bins, pooled, scored
from studies.mismatch.worlds.world import Corpus, LabelledWorld

TRUTH = {"effect": "wheelbase", "component": "a", "intervals": [], "parameters": {}, "acceptable": []}
LABELS = {
    "healthy": {"kind": "null", "effects": []},
    "worn": {"kind": "single", "effects": [TRUTH]},
}


def finding(effect, probability):
    where = {"intervals": []}
    return {
        "effect": effect, "component": "a", "probability": probability, "alternatives": [], "where": where,
        "parameters": {},
    }  # fmt: skip


ANSWERS = {
    "healthy": {"findings": [finding("wheelbase", 0.95)], "fit": None},
    "worn": {
        "findings": [finding("wheelbase", 0.97), finding("turn_scrub", 0.3)],
        "fit": {"heldout": {"before": 4.0, "after": 1.0}},
    },
}


def corpus(tmp_path, name="set", *, foreign=True):
    return Corpus(LabelledWorld(name, name, tmp_path, foreign=foreign), tmp_path, LABELS)


def line(score, name):
    return next(each for each in score.lines if each.name == name)


def test_a_score_counts_what_the_labels_say(tmp_path):
    score = scored(corpus(tmp_path), ANSWERS)
    assert line(score, "false alarm on a null").text == "1 of 1"
    assert line(score, "false alarm on a null").is_missed
    assert line(score, "one effect: right first").text == "1 of 1"
    assert line(score, "said 0.9 or more, and wrong").text == "1 of 2"
    assert line(score, "held-out residual, before -> after").text == "4.00 -> 1.00"
    assert line(score, "unknown called unknown").text == "-"


def test_worlds_that_others_made_are_pooled_case_by_case(tmp_path):
    names = (("first", True), ("second", True), ("ours", False))
    asked = [(corpus(tmp_path, name, foreign=foreign), ANSWERS) for name, foreign in names]
    (score,) = pooled(asked)
    assert score.cases == 4
    assert line(score, "one effect: right first").text == "2 of 2"
    assert pooled(asked[1:]) == []


def test_a_score_is_an_object_without_numbers_that_json_does_not_have(tmp_path):
    text = json.dumps(scored(corpus(tmp_path), ANSWERS).as_json(), allow_nan=False)
    assert json.loads(text)["cases"] == 2


def test_reliability_holds_what_was_said_against_what_is_right():
    low, high = bins(LABELS, ANSWERS)
    assert (low.said, low.right, low.of) == (0.3, 0, 1)
    assert (high.said, high.right, high.of) == (pytest.approx(0.96), 1, 2)
    assert high.interval[0] < high.share < high.interval[1]


def test_each_world_has_a_reliability_diagram_even_where_nothing_was_said(tmp_path):
    panels = {"worn": bins(LABELS, ANSWERS), "silent": [], **{str(number): [] for number in range(3)}}
    plot_reliability(panels, tmp_path / "reliability.png")
    assert (tmp_path / "reliability.png").read_bytes().startswith(b"\x89PNG")
