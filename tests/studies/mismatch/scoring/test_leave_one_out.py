"""Leave one out: a missing effect is answered by unknown, a look-alike, a wrong name, or nothing."""

import pytest

from studies.mismatch.scoring.leave_one_out import concealing, left_out_rows, outcome

TRUTH = {
    "effect": "wheelbase",
    "component": "a",
    "acceptable": [{"effect": "turn_scrub", "component": "a"}],
}
LABEL = {"kind": "single", "effects": [TRUTH]}


def finding(effect, component="a", probability=0.9):
    return {"effect": effect, "component": component, "probability": probability}


def answer(*findings):
    return {"findings": list(findings)}


@pytest.mark.parametrize(
    ("given", "wanted"),
    [
        (answer(finding("unknown")), "unknown"),
        (answer(finding("turn_scrub")), "acceptable"),
        (answer(finding("turn_scrub"), finding("unknown")), "unknown"),
        (answer(finding("turn_scrub", "b")), "wrong name"),
        (answer(finding("unknown"), finding("bump", "a.left")), "wrong name"),
        (answer(finding("bump", "a.left", 0.4)), "nothing"),
        (answer(), "nothing"),
    ],
)
def test_an_answer_has_one_outcome(given, wanted):
    assert outcome(LABEL, given) == wanted


def test_only_cases_that_conceal_one_named_effect_are_asked_about():
    labels = {
        "one": LABEL,
        "healthy": {"kind": "null", "effects": []},
        "two": {"kind": "masked", "effects": [TRUTH, TRUTH]},
        "strange": {"kind": "unknown", "effects": [{"effect": "unknown", "component": "a"}]},
    }
    assert concealing(labels) == {"one": "wheelbase"}


def test_there_is_a_row_for_each_effect_and_one_for_all():
    other = {"kind": "single", "effects": [{"effect": "bump", "component": "a.left", "acceptable": []}]}
    labels = {"first": LABEL, "second": LABEL, "third": other, "not asked": LABEL}
    answers = {"first": answer(finding("unknown")), "second": answer(), "third": answer(finding("latency"))}
    rows = {row.effect: row for row in left_out_rows(labels, answers)}
    assert list(rows) == ["bump", "wheelbase", "all"]
    assert rows["wheelbase"].cases == 2
    assert rows["all"].outcomes == {"unknown": 1, "nothing": 1, "wrong name": 1}
