"""`omnimate prove`: which tools are asked about which cases, and that their tables are printed."""

import pytest

from omnimate.proof.cases import cases

ANSWER = {"verdict": "agreement", "findings": [], "fit": None}


@pytest.fixture
def asked(monkeypatch):
    """Let nothing be driven and nothing be diagnosed; return the names of all questions, a list a bar."""
    questions = []

    def corpus(folder, _jobs, _tell, **kinds):
        folder.mkdir(parents=True)
        found = cases(kinds["quick"])
        return {f"own-{number:04d}": label(case) for number, case in enumerate(found)}

    def answers(_ask, wanted, _jobs, _tell, _kept=None):
        questions.append(list(wanted))
        return dict.fromkeys(wanted, ANSWER)

    monkeypatch.setattr("omnimate.proof.run.write_corpus", corpus)
    monkeypatch.setattr("omnimate.proof.run.ask_all", answers)
    return questions


def label(case):
    effects = [
        {"effect": effect, "component": component, "intervals": [], "parameters": {}, "acceptable": []}
        for effect, component in case.effects
    ]
    return {"kind": case.kind, "effects": effects}


def test_quick_asks_more_about_a_few_cases_only(omnimate, asked):
    shown = omnimate("prove", "--quick", "--no-contact").out
    assert [len(names) for names in asked] == [len(cases(quick=True)), 3 * 3, 3 * 4, 1]
    for title in ("Baselines", "Ablations", "Leave one out"):
        assert title in shown


def test_recordings_that_are_refused_are_no_silent_misses(omnimate, asked, monkeypatch):
    refused = {"verdict": "error", "says": "can.log:1: no CAN frame", "findings": [], "fit": None}
    monkeypatch.setattr(
        "omnimate.proof.run.ask_all",
        lambda _ask, wanted, _jobs, _tell, _kept=None: dict.fromkeys(wanted, refused),
    )
    shown = omnimate(
        "prove", "--quick", "--no-contact", "--no-baselines", "--no-ablations", "--no-leave-one-out"
    )
    count = len(cases(quick=True))
    assert f"{count} of {count} cases were refused" in shown.out
    assert "can.log:1: no CAN frame" in shown.out


def test_every_case_is_asked_about_on_request(omnimate, asked):
    shown = omnimate(
        "prove", "--quick", "--no-contact", "--baselines", "--no-ablations", "--leave-one-out"
    ).out
    whole = cases(quick=True)
    alone = [one for one in whole if one.kind in {"single", "masked"} and len(one.effects) == 1]
    assert [len(names) for names in asked] == [len(whole), 3 * len(whole), len(alone)]
    assert "STLSQ" in shown
    assert "Ablations" not in shown


def test_the_full_run_asks_about_everything(omnimate, asked, tmp_path):
    omnimate("prove", "--no-contact", "--real", tmp_path)
    whole = len(cases(quick=False))
    assert [len(names) for names in asked][:3] == [whole, 3 * whole, 4 * whole]


def test_the_answers_of_all_tools_are_kept(omnimate, asked, tmp_path):
    omnimate("prove", "--quick", "--no-contact", "--out", tmp_path / "kept")
    kept = {path.name for path in (tmp_path / "kept").glob("*.json")}
    assert kept == {
        *("own.json", "corpus.json", "answers.json", "baselines-own.json", "ablations-own.json"),
        "leave-one-out-own.json",
    }


def test_a_run_that_was_stopped_goes_on_with_the_same_corpus_and_no_other(
    omnimate, asked, tmp_path, monkeypatch
):
    kept = tmp_path / "kept"
    omnimate("prove", "--quick", "--no-contact", "--out", kept)
    monkeypatch.setattr("omnimate.proof.run.write_corpus", None)
    assert "independent engine" in omnimate("prove", "--quick", "--no-contact", "--out", kept).out
    refused = omnimate("prove", "--quick", "--no-contact", "--seed", "2", "--out", kept)
    assert refused.code != 0
    assert "a folder of its own" in refused.err


def test_a_corpus_that_was_not_finished_is_not_mistaken_for_one(omnimate, asked, tmp_path):
    (tmp_path / "kept" / "own").mkdir(parents=True)
    refused = omnimate("prove", "--quick", "--no-contact", "--out", tmp_path / "kept")
    assert refused.code != 0
    assert "not finished" in refused.err
