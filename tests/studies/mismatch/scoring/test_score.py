"""The score: a perfect answer is perfect, a wrong one is counted wrong, and worlds have one each."""

import json

import pytest

from studies.figures import plot_reliability
from studies.mismatch.scoring.judging import all_right, reported_instead
from studies.mismatch.scoring.score import bins, pooled, rows, scored, share
from studies.mismatch.worlds.world import Corpus, LabelledWorld
from tests.studies.mismatch.answers import answer, effect, finding, label

TRUTH = effect(acceptable=[("turn_scrub", "a")], ratio=1.01)


def table(labels, answers):
    return {row.name: row for row in rows({"x": labels}, {"x": answers})}


FIRST, EXACT, SURE_WRONG, ALARM = (
    "one effect: right first",
    "one effect: exactly the truth first",
    "said 0.9 or more, and wrong",
    "false alarm on a null",
)


@pytest.mark.parametrize(
    ("findings", "wanted"),
    [
        (
            [finding(ratio=1.0101)],
            {FIRST: 1, EXACT: 1, SURE_WRONG: 0, "parameter within 2 sigma": 1, "95 % set holds the truth": 1},
        ),
        ([finding("turn_scrub")], {FIRST: 1, EXACT: 0}),
        ([finding("wheelbase", "b")], {FIRST: 0, SURE_WRONG: 1}),
        ([], {FIRST: 0}),
        ([finding(ratio=1.011)], {"parameter within 2 sigma": 0}),
    ],
    ids=["perfect", "what the drive cannot tell apart", "wrong place", "silence", "wrong size"],
)
def test_an_answer_about_one_effect_is_worth_what_it_says(findings, wanted):
    found = table(label("single", TRUTH), answer(*findings))
    assert {name: found[name].value for name in wanted} == wanted


@pytest.mark.parametrize(("probability", "alarm"), [(0.95, 1.0), (0.4, 0.0)])
def test_any_assertion_on_a_null_is_a_false_alarm(probability, alarm):
    assert table(label("null"), answer(finding(probability=probability)))[ALARM].value == alarm


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
    assert table(two, answer(finding("lateral_slip")))[SURE_WRONG].value == 0.0


def test_what_counts_as_right_in_place_of_the_truth_is_reported():
    findings = {"exact": finding(), "alike": finding("turn_scrub"), "wrong": finding("joint_bias", "joint_a")}
    labels = dict.fromkeys(findings, label("single", TRUTH))
    answers = {name: answer(one) for name, one in findings.items()}
    assert reported_instead(labels, answers) == {("wheelbase a", "turn_scrub a"): 1}


LABELS = {"healthy": label("null"), "worn": label("single", effect(ratio=1.01))}
ANSWERS = {
    "healthy": answer(finding()),
    "worn": answer(finding(probability=0.97), finding("turn_scrub", probability=0.3), heldout=(4.0, 1.0)),
}


def corpus(tmp_path, name="set", *, foreign=True):
    return Corpus(LabelledWorld(name, name, tmp_path, foreign=foreign), tmp_path, LABELS)


def test_a_score_counts_what_the_labels_say_and_is_an_object_of_json(tmp_path):
    score = scored(corpus(tmp_path), ANSWERS)
    lines = {line.name: line for line in score.lines}
    assert lines[ALARM].is_missed
    assert {name: lines[name].text for name in (ALARM, FIRST, SURE_WRONG)} == {
        ALARM: "1 of 1",
        FIRST: "1 of 1",
        SURE_WRONG: "1 of 2",
    }
    assert lines["held-out residual, before -> after"].text == "4.00 -> 1.00"
    assert lines["unknown called unknown"].text == "-"
    assert json.loads(json.dumps(score.as_json(), allow_nan=False))["cases"] == 2


def test_worlds_that_others_made_are_pooled_case_by_case(tmp_path):
    names = (("first", True), ("second", True), ("ours", False))
    asked = [(corpus(tmp_path, name, foreign=foreign), ANSWERS) for name, foreign in names]
    (score,) = pooled(asked)
    assert score.cases == 4
    assert next(line for line in score.lines if line.name == FIRST).text == "2 of 2"
    assert pooled(asked[1:]) == []


def test_reliability_holds_what_was_said_against_what_is_right(tmp_path):
    low, high = bins(LABELS, ANSWERS)
    assert (low.said, low.right, low.of) == (0.3, 0, 1)
    assert (high.said, high.right, high.of) == (pytest.approx(0.96), 1, 2)
    assert high.interval[0] < high.share < high.interval[1]
    panels = {"worn": [low, high], "silent": [], **{str(number): [] for number in range(3)}}
    plot_reliability(panels, tmp_path / "reliability.png")
    assert (tmp_path / "reliability.png").read_bytes().startswith(b"\x89PNG")
