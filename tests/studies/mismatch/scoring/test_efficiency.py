"""Efficiency: the strength found half of the time, and twins that say what an injection brought."""

import math

import numpy as np
import pytest

from studies.mismatch.scoring.efficiency import efficiency
from studies.mismatch.scoring.judging import beyond_twins, is_found
from studies.mismatch.scoring.score import rows
from tests.studies.mismatch.answers import answer, effect, finding, label

TWIN = label("null")


def injected(strength=12.0, acceptable=(), **more):
    return label("injected", effect(acceptable=acceptable), strength=strength, **more)


def test_the_strength_found_half_of_the_time_is_that_of_the_law_by_which_they_were_found():
    chance = np.random.default_rng(1)
    strength = np.exp(chance.uniform(0.0, math.log(30.0), 3000))
    found = chance.random(3000) < 1.0 / (1.0 + (7.0 / strength) ** 4)
    labels = {str(number): injected(float(each)) for number, each in enumerate(strength)}
    answers = {str(number): answer(finding()) if each else answer() for number, each in enumerate(found)}
    fitted = efficiency(labels, answers)
    assert fitted.half == pytest.approx(7.0, rel=0.05)
    assert fitted.at(np.array([7.0]))[0] == pytest.approx(0.5, abs=0.03)


def test_a_tool_that_finds_nothing_finds_no_strength_half_of_the_time():
    assert efficiency({"x": injected()}, {"x": answer()}).half == math.inf
    assert math.isnan(efficiency({}, {}).half)


def test_a_set_that_the_drive_cannot_tell_apart_is_found_where_it_is_asserted_as_a_whole():
    both = finding("turn_scrub", "a", 0.45, [("wheelbase", 0.4)])
    assert is_found(injected(), answer(both))
    assert not is_found(injected(), answer(finding("turn_scrub", "a", 0.25, [("wheelbase", 0.2)])))
    assert not is_found(injected(), answer(finding("turn_scrub", "a", 0.96, [("wheelbase", 0.01)])))


def test_a_wrong_finding_that_the_twin_has_as_well_is_not_held_against_the_injection():
    labels = {"case": injected(twin="twin"), "twin": TWIN}
    same, other = finding("traction_slip"), finding("lateral_slip")
    answers = {"case": answer(finding(), same, other), "twin": answer(same)}
    assert [each["effect"] for each in beyond_twins(labels, answers)["case"]["findings"]] == [
        "wheelbase",
        "lateral_slip",
    ]
    table = {row.name: row for row in rows(labels, answers)}
    assert table["injected: a wrong finding that the twin has not"].text == "1 of 1"
    assert table["said 0.9 or more, and wrong"].text == "2 of 3"
    assert table["false alarm on a null"].text == "1 of 1"


def test_what_looks_like_a_weak_injection_and_is_in_the_twin_too_is_not_found():
    labels = {"case": injected(1.5, [("turn_scrub", "a")], twin="twin"), "twin": TWIN}
    answers = {"case": answer(finding("turn_scrub")), "twin": answer(finding("turn_scrub"))}
    assert not is_found(labels["case"], beyond_twins(labels, answers)["case"])
    assert is_found(labels["case"], answers["case"])


def test_only_strong_injections_must_be_named_first():
    labels = {"strong": injected(10.0), "weak": injected(9.0)}
    answers = {"strong": answer(finding()), "weak": answer()}
    table = {row.name: row for row in rows(labels, answers)}
    assert table["injected, 10 sigma: right first or in its set"].text == "1 of 1"
