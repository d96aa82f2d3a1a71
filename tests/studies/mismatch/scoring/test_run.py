"""Running a tool over a corpus: refusals are answers, which are kept as they come and not asked for twice."""

import json

import pytest

from omnimate.mismatch import Diagnosis
from omnimate.vehicle.errors import OmnimateError
from studies.mismatch.engines.scene import Case, make
from studies.mismatch.run import answered, answered_by, ask_all


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


def test_a_tool_is_given_the_recordings_that_the_label_names_and_answers_in_json(tmp_path):
    label = make(tmp_path, Case("null", (), "squares", "mocap", trucks=1, note="short"), 3)
    (tmp_path / "labels of something else").mkdir()
    answer = answered((tmp_path, label), lambda recordings: Diagnosis("agreement", f"{len(recordings)} seen"))
    assert (answer["verdict"], answer["says"], answer["findings"]) == ("agreement", "1 seen", [])


@pytest.mark.parametrize(
    ("error", "says"),
    [
        (OmnimateError("no poses"), "no poses"),
        (ZeroDivisionError("division by zero"), "FAILED with ZeroDivisionError: division by zero"),
    ],
)
def test_a_tool_that_refuses_or_fails_is_shown_as_that_and_the_study_goes_on(tmp_path, error, says):
    def fail(_recordings):
        raise error

    answer = answered_by((fail, (tmp_path, {"recordings": []})))
    assert answer == {"verdict": "error", "says": says, "findings": [], "fit": None}
