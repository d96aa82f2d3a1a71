"""`python -m studies faults`: a table, the pace, and the shortest session that breaks a law."""

from studies.faults import command
from studies.faults.script import Fault, Script
from studies.faults.session import Outcome

FAULT = Fault("emcy", 6.0, 0.5, node=2)


def sessions(monkeypatch, violations):
    """Let two sessions be driven at once, each with these violations."""
    outcome = Outcome(Script("single", 1, (FAULT, FAULT)), violations, "abc")
    outcome.injected["emcy", "running"] = 1
    monkeypatch.setattr(command, "run_all", lambda _seed, count, _jobs: iter([outcome] * count))
    monkeypatch.setattr(command, "run", lambda script: Outcome(script, violations if script.faults else []))


def test_faults_are_counted_by_kind_and_phase(studies, monkeypatch):
    sessions(monkeypatch, [])
    shown = studies("faults", "--hours", 0.05)
    assert shown.code == 0
    row = next(line.split() for line in shown.out.splitlines() if "emcy" in line)
    assert row == ["emcy", "0", "2", "0", "0", "0", "0"]
    assert "sessions with violations: 0 of 2; trace " in shown.out


def test_a_session_that_breaks_a_law_is_printed_as_short_as_it_can_be(studies, monkeypatch):
    sessions(monkeypatch, ["6.000 s: no fault explains the report"])
    shown = studies("faults", "--hours", 0.03)
    assert shown.code == 1
    assert f"run({Script('single', 1, (FAULT,))})" in shown.out
