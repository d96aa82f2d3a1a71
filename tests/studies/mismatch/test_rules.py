"""`python -m studies rules`: the rules of the diagnosis are left out, one at a time."""

from unittest.mock import patch

import pytest

from studies.mismatch.rules import RULES, WHOLE, table
from tests.studies.mismatch.answers import answer, effect, finding, label, write_healthy_set


@pytest.mark.parametrize("rule", RULES)
def test_every_rule_has_a_place_in_the_method(rule):
    with patch(*RULES[rule]):
        pass


def test_a_rule_is_judged_by_the_answers_that_change_without_it():
    labels = {name: label("single", effect("bump", "a.left")) for name in ("first", "second")}
    whole = dict.fromkeys(labels, answer(finding("bump", "a.left")))
    shown = table(
        labels, {WHOLE: whole, "trains of obstacles": {**whole, "second": answer(finding("latency", "link"))}}
    )
    cells = {column.header: list(column.cells) for column in shown.columns}
    assert cells["other names"] == ["0", "1"]
    assert cells["one effect: right first"] == ["2/2", "1/2"]
    assert cells["said 0.9 or more, and wrong"] == ["0/2", "1/2"]


def test_a_rule_is_left_out_where_it_decides_and_nowhere_else(studies, tmp_path, monkeypatch):
    asked = []

    def answers(_ask, wanted, _jobs, _tell, _kept=None):
        asked.extend(rule for rule, _ in wanted.values())
        return dict.fromkeys(wanted, answer())

    write_healthy_set(tmp_path / "data" / "concealed", 2)
    monkeypatch.setattr("studies.mismatch.run.ask_all", answers)
    rule = "overdispersion"
    place = "--data", tmp_path / "data", "--out", tmp_path / "out"
    assert "0/2" in studies("rules", "--world", "concealed", "--rule", rule, *place).out
    assert asked == [WHOLE, WHOLE, rule, rule]


def test_an_unknown_rule_is_refused_with_those_that_there_are(studies, tmp_path):
    refused = studies("rules", "--world", "unnamed", "--rule", "luck", "--out", tmp_path)
    assert refused.code == 1
    assert "no rule luck; expected" in refused.err
