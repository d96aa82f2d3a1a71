"""Leave one out: a missing effect is answered by unknown, a look-alike, a wrong name, or nothing."""

import pytest

from studies.mismatch.scoring.judging import concealing, left_out_rows, outcome
from tests.studies.mismatch.answers import answer, effect, finding, label

TRUTH = effect(acceptable=[("turn_scrub", "a")])
LABEL = label("single", TRUTH)


@pytest.mark.parametrize(
    ("findings", "wanted"),
    [
        ([finding("unknown")], "unknown"),
        ([finding("turn_scrub")], "acceptable"),
        ([finding("turn_scrub"), finding("unknown")], "unknown"),
        ([finding("turn_scrub", "b")], "wrong name"),
        ([finding("unknown"), finding("bump", "a.left")], "wrong name"),
        ([finding("bump", "a.left", 0.4)], "nothing"),
        ([], "nothing"),
    ],
)
def test_an_answer_has_one_outcome(findings, wanted):
    assert outcome(LABEL, answer(*findings)) == wanted


def test_cases_that_conceal_one_named_effect_have_a_row_for_each_effect_and_one_for_all():
    labels = {
        "first": LABEL, "second": LABEL, "not asked": LABEL,
        "third": label("single", effect("bump", "a.left")),
        "strange": label("unknown", effect("unknown")), "healthy": label("null"),
        "two": label("masked", TRUTH, TRUTH),
    }  # fmt: skip
    assert list(concealing(labels)) == ["first", "second", "not asked", "third"]
    answers = {
        "first": answer(finding("unknown")),
        "second": answer(),
        "third": answer(finding("latency")),
    }
    rows = left_out_rows(labels, answers)
    assert list(rows) == ["bump", "wheelbase", "all"]
    assert rows["wheelbase"].total() == 2
    assert rows["all"] == {"unknown": 1, "nothing": 1, "wrong name": 1}
