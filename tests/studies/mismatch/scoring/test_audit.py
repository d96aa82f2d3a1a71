"""What was reported in place of the truth, driven by the engine that concealed it."""

import pytest

from studies.mismatch.engines.scene import Case, cases, scene
from studies.mismatch.scoring.audit import audited, questions
from tests.studies.mismatch.answers import answer, effect, finding, label

SEED = 5


def case(effect, component, poses="none"):
    return Case("single", ((effect, component),), "squares", poses)


def asked(concealed, *findings, number=0, cases=None):
    """Return what is to be audited of an answer about a case that conceals one effect."""
    labels = {f"own-{number:04d}": label("single", effect(*concealed.effects[0]))}
    answers = dict.fromkeys(labels, answer(*findings))
    return questions(labels, answers, cases or [concealed], SEED)


@pytest.mark.slow
def test_the_truth_by_another_name_leaves_nothing():
    concealed = case("link_bias", "link", poses="mocap")
    bias = scene(concealed, 10_000 * SEED).faults[0]["bias"]
    nothing = finding("joint_bias", "joint_a", bias=0.0)
    (question,) = asked(concealed, nothing, finding("link_bias", "link", bias=bias))
    audit = audited(question)
    assert audit.left == pytest.approx(0.0, abs=1e-9)
    assert audit.truth_alone > 0.0
    assert audit.reported == "joint_bias joint_a + link_bias link"


@pytest.mark.slow
def test_a_name_that_does_something_else_leaves_more_than_it_takes():
    (question,) = asked(case("wheel_diameter", "a.left"), finding("wheelbase", "b", ratio=1.03))
    audit = audited(question)
    assert not audit.right
    assert audit.left > audit.truth_alone > 2.0


@pytest.mark.slow
def test_a_name_of_no_size_leaves_all_that_the_truth_does():
    (question,) = asked(case("turn_scrub", "a"), finding("wheelbase", "a", ratio=1.0))
    audit = audited(question)
    assert audit.left == audit.truth_alone > 1.0


@pytest.mark.parametrize(
    ("findings", "count"),
    [
        ([finding("slip_patch", "b.right", fraction=0.01)], 1),
        ([finding("radius_step", "b.right", ratio=1.01)], 0),
        ([finding("unknown", "b.right")], 0),
        ([finding("latency", "poses", delay=0.1)], 0),
        ([finding("slip_patch", "b.right", probability=0.4, fraction=0.01)], 0),
        ([], 0),
    ],
)
def test_only_other_names_that_the_engine_can_drive_are_asked_about(findings, count):
    assert len(asked(case("radius_step", "b.right"), *findings)) == count


def test_numbers_of_cases_are_those_of_the_corpus():
    whole = cases(quick=False)
    number = next(at for at, case in enumerate(whole) if case.kind == "single")
    (question,) = asked(whole[number], finding("wheelbase", "b", ratio=1.01), number=number, cases=whole)
    assert question.case is whole[number]
    assert question.seed == 10_000 * SEED + number
