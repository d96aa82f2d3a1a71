"""What is asked of a tool, and that refusals are answers."""

from omnimate.mismatch import Diagnosis
from omnimate.vehicle.errors import OmnimateError
from studies.mismatch.engines.cases import Case, make
from studies.mismatch.run import answered, answered_by


def test_a_tool_is_given_the_recordings_that_the_label_names_and_answers_in_json(tmp_path):
    label = make(tmp_path, Case("null", (), "squares", "mocap", trucks=1, note="short"), 3)
    (tmp_path / "labels of something else").mkdir()
    answer = answered((tmp_path, label), lambda recordings: Diagnosis("agreement", f"{len(recordings)} seen"))
    assert (answer["verdict"], answer["says"], answer["findings"]) == ("agreement", "1 seen", [])


def test_a_tool_that_fails_is_shown_as_that_and_the_study_goes_on(tmp_path):
    def fail(_recordings):
        raise ZeroDivisionError("division by zero")

    answer = answered((tmp_path, {"recordings": []}), fail)
    assert answer["says"] == "FAILED with ZeroDivisionError: division by zero"


def test_recordings_that_are_refused_are_an_answer_too(tmp_path):
    def refuse(_recordings):
        raise OmnimateError("no poses")

    assert answered_by((refuse, (tmp_path, {"recordings": []}))) == {
        "verdict": "error",
        "says": "no poses",
        "findings": [],
        "fit": None,
    }
