"""Leave one out: a missing effect is answered by unknown, a look-alike, a wrong name, or nothing."""

import pytest

from studies.mismatch.scoring.leave_one_out import concealing, left_out_rows, outcome

ALIKE = {"effect": "turn_scrub", "component": "a"}
TRUTH = {"effect": "wheelbase", "component": "a", "acceptable": [ALIKE]}
LABEL = {"kind": "single", "effects": [TRUTH]}


def answer(*findings):
    names = ("effect", "component", "probability")
    return {"findings": [dict(zip(names, (*each, "a", 0.9)[:3], strict=True)) for each in findings]}


@pytest.mark.parametrize(
    ("findings", "wanted"),
    [
        ([("unknown",)], "unknown"),
        ([("turn_scrub",)], "acceptable"),
        ([("turn_scrub",), ("unknown",)], "unknown"),
        ([("turn_scrub", "b", 0.9)], "wrong name"),
        ([("unknown",), ("bump", "a.left", 0.9)], "wrong name"),
        ([("bump", "a.left", 0.4)], "nothing"),
        ([], "nothing"),
    ],
)
def test_an_answer_has_one_outcome(findings, wanted):
    assert outcome(LABEL, answer(*findings)) == wanted


def test_cases_that_conceal_one_named_effect_have_a_row_for_each_effect_and_one_for_all():
    other = {"kind": "single", "effects": [{"effect": "bump", "component": "a.left", "acceptable": []}]}
    strange = {"kind": "unknown", "effects": [{"effect": "unknown", "component": "a"}]}
    labels = {
        "first": LABEL, "second": LABEL, "third": other, "not asked": LABEL, "strange": strange,
        "healthy": {"kind": "null", "effects": []}, "two": {"kind": "masked", "effects": [TRUTH, TRUTH]},
    }  # fmt: skip
    assert list(concealing(labels)) == ["first", "second", "third", "not asked"]
    answers = {"first": answer(("unknown",)), "second": answer(), "third": answer(("latency",))}
    rows = left_out_rows(labels, answers)
    assert list(rows) == ["bump", "wheelbase", "all"]
    assert rows["wheelbase"].total() == 2
    assert rows["all"] == {"unknown": 1, "nothing": 1, "wrong name": 1}
