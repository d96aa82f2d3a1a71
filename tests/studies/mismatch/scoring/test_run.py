"""Running a tool over a corpus: answers are kept as they come, and not asked for twice."""

import json

import pytest

from studies.mismatch.run import ask_all


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
