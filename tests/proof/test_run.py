"""Running a tool over a corpus: answers are kept as they come, and not asked for twice."""

import json

import pytest

from omnimate.proof.cases import cases
from omnimate.proof.run import ask_all, write_corpus


def half(number):
    if number == 3:
        raise ValueError("no answer")
    return {"half": number / 2}


def quiet(_done, _total):
    """Say nothing."""


def test_answers_that_came_before_a_stop_are_kept_and_not_asked_for_again(tmp_path):
    kept = tmp_path / "answers.jsonl"
    with pytest.raises(ValueError, match="no answer"):
        ask_all(half, {"two": 2, "three": 3}, 1, quiet, kept)
    assert [json.loads(line) for line in kept.read_text().splitlines()] == [["two", {"half": 1.0}]]
    kept.write_text(json.dumps(["three", {"half": "known"}]) + "\n")
    answers = ask_all(half, {"two": 2, "three": 3}, 1, quiet, kept)
    assert answers == {"two": {"half": 1.0}, "three": {"half": "known"}}


def test_a_line_that_a_stop_left_half_written_is_asked_for_again(tmp_path):
    kept = tmp_path / "answers.jsonl"
    kept.write_text(json.dumps(["two", {"half": "known"}]) + '\n["four", {"ha')
    answers = ask_all(half, {"two": 2, "four": 4}, 1, quiet, kept)
    assert answers == {"two": {"half": "known"}, "four": {"half": 2.0}}
    assert dict(json.loads(line) for line in kept.read_text().splitlines()) == answers


def test_a_part_of_the_corpus_is_drawn_by_the_seed(tmp_path, monkeypatch):
    monkeypatch.setattr(
        "omnimate.proof.run.make", lambda _folder, case, seed: {"kind": case.kind, "seed": seed}
    )
    monkeypatch.setattr("omnimate.proof.run.ProcessPoolExecutor", InThisOne)
    drawn = [
        write_corpus(tmp_path / name, 1, quiet, quick=False, seed=seed, part=0.1)
        for name, seed in (("one", 1), ("again", 1), ("other", 2))
    ]
    assert drawn[0].keys() == drawn[1].keys() != drawn[2].keys()
    assert len(drawn[0]) == round(0.1 * len(cases(quick=False)))


class InThisOne:
    """A pool of no other process."""

    map = staticmethod(map)

    def __init__(self, _jobs, **_how):
        pass

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass
