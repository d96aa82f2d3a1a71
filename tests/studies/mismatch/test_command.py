"""`python -m studies prove`: the worlds asked for, and one table with its JSON and its figure."""

import json
from functools import partial

import pytest

from studies.mismatch.engines.scene import cases, make
from tests.studies.mismatch.answers import effect, label, write_healthy_set

ANSWER = {"verdict": "agreement", "findings": [], "fit": None}
KINDS = ("concealed", "concealed2", "contact")


@pytest.fixture
def asked(monkeypatch):
    """Let nothing be driven and nothing be diagnosed; return the names of all questions, a list a bar."""
    questions = []

    def answers(ask, wanted, _jobs, _tell, _kept=None):
        if isinstance(ask, partial) and ask.args == (make,):
            return {
                name: label(case.kind, *(effect(*each) for each in case.effects))
                for name, (_, case, _) in wanted.items()
            }
        questions.append(list(wanted))
        return dict.fromkeys(wanted, ANSWER)

    monkeypatch.setattr("studies.mismatch.run.ask_all", answers)
    return questions


@pytest.fixture
def data(tmp_path):
    """Return a folder with three labelled sets."""
    for number, kind in enumerate(KINDS, start=1):
        write_healthy_set(tmp_path / "data" / kind, number)
    return tmp_path / "data"


def test_one_table_has_a_column_for_each_world_that_is_asked_for(studies, asked, data):
    shown = studies("prove", "--world", "concealed", "--world", "contact", "--data", data).out
    assert [len(names) for names in asked] == [1, 3]
    assert "false alarm on a null" in shown
    assert "0 of 1" in shown
    assert "0 of 3" in shown
    assert "foreign, pooled" in shown
    assert "concealed2" not in shown
    assert "labels of contact: 3, SHA-256 " in shown  # sealed before the tool is asked


def test_a_world_that_is_not_there_is_left_out_and_that_is_said(studies, asked, tmp_path):
    shown = studies("prove", "--world", "concealed", "--data", tmp_path)
    assert shown.code == 0
    assert "concealed is left out" in shown.out


def test_the_table_is_written_as_json_and_drawn(studies, asked, data, tmp_path):
    kept, figures = tmp_path / "kept", tmp_path / "drawn"
    figures.mkdir()
    studies("prove", "--world", "concealed", "--data", data, "--out", kept, "--figures", figures)
    written = json.loads((kept / "proof.json").read_text())
    assert written["worlds"]["concealed"]["lines"][0]["name"] == "false alarm on a null"
    assert (figures / "reliability.png").read_bytes().startswith(b"\x89PNG")


def test_recordings_that_are_refused_are_no_silent_misses(studies, asked, data, monkeypatch):
    refused = {"verdict": "error", "says": "can.log:1: no CAN frame", "findings": [], "fit": None}
    monkeypatch.setattr(
        "studies.mismatch.run.ask_all",
        lambda _ask, wanted, _jobs, _tell, _kept=None: dict.fromkeys(wanted, refused),
    )
    shown = studies("prove", "--world", "contact", "--data", data)
    assert "3 of 3 cases were refused or failed" in shown.out
    assert "can.log:1: no CAN frame" in shown.out


def test_as_many_cases_are_asked_about_as_are_wanted(studies, asked):
    studies("prove", "--cases", "7", "--world", "engine")
    assert [len(names) for names in asked] == [7]


def test_the_engines_cases_are_asked_about_without_what_is_concealed_on_request(studies, asked):
    shown = studies("prove", "--quick", "--world", "engine", "--leave-one-out").out
    whole = cases(quick=True)
    alone = [one for one in whole if one.kind in {"single", "masked"} and len(one.effects) == 1]
    assert [len(names) for names in asked] == [len(whole), len(alone)]
    assert "Leave one out" in shown


def test_a_study_that_was_stopped_goes_on_with_the_same_cases_and_no_others(studies, asked, tmp_path):
    kept = tmp_path / "kept"
    studies("prove", "--quick", "--world", "engine", "--out", kept)
    assert "own engine" in studies("prove", "--quick", "--world", "engine", "--out", kept).out
    refused = studies("prove", "--quick", "--world", "engine", "--seed", "2", "--out", kept)
    assert refused.code == 1
    assert "a folder of its own" in refused.err
