"""What is small, hollow, of another one's making or worse in the open loop is not asserted."""

from types import SimpleNamespace

import numpy as np
import pytest

from mismatch.diagnosis import Change, Finding, Fit, Where
from mismatch.doubt import believed, is_something
from mismatch.instead import contradicted, dwarfed

FINDINGS = (Finding("wheel_diameter", "a.left", 0.98), Finding("unknown", "a", 0.9))


def fit(after):
    return Fit("", Change(1.1, 1.0), Change(1.1, 1.0), rerun={"a position": Change(0.01, after)})


@pytest.mark.parametrize("after", [0.004, 0.010, 0.011])
def test_effects_that_lead_nearer_or_as_near_keep_their_probability(after):
    assert contradicted(FINDINGS, fit(after)) == FINDINGS


def test_what_explains_next_to_nothing_of_what_nobody_does_is_a_possibility():
    small, large = found("link_scale", "link", 0.02), found("slip_patch", "b.right", 0.6)
    assert dwarfed([small, large], 0.1) == (small, large)
    doubted, kept = dwarfed([small, large], 0.6)
    assert kept == large
    assert doubted.probability < 0.5


def test_effects_that_lead_farther_astray_become_possibilities_and_the_unknown_stays():
    named, unknown = contradicted(FINDINGS, fit(0.015))
    assert named.probability == pytest.approx(0.98 / 1.5**2)
    assert unknown == FINDINGS[1]


def test_where_the_strongest_is_contradicted_something_unknown_acts():
    strong, weak = found("link_scale", "link", 0.9), found("joint_bias", "joint_a", 0.1)
    unknown, named = contradicted([strong, weak], fit(0.03))
    assert (unknown.effect, unknown.component, named.effect) == ("unknown", "link", "joint_bias")
    (instead,) = unknown.alternatives
    assert instead.effect == "link_scale"
    assert unknown.probability + instead.probability == pytest.approx(strong.probability)
    assert unknown.probability > 0.5 > named.probability
    assert [one.effect for one in contradicted([strong, weak], fit(0.0125))] == ["link_scale", "joint_bias"]


def test_without_a_rerun_nothing_is_contradicted():
    assert contradicted(FINDINGS, Fit("", Change(1.0, 1.0), Change(1.0, 1.0))) == FINDINGS


def found(effect, component, explained, probability=0.99, intervals=()):
    return Finding(effect, component, probability, (), Where((), intervals, "always"), (), explained)


REFINED = SimpleNamespace(
    regression=SimpleNamespace(white=np.zeros((1000, 1))), terms=(), values=(), places=()
)


def told(*findings, dispensable=frozenset()):
    answers = believed(findings, REFINED, 1e4, dispensable)
    return {(one.effect, one.component): one.probability for one in answers}


def test_what_explains_next_to_nothing_beside_a_stronger_one_is_not_told():
    assert told(found("clock_drift", "joint_b", 1.0), found("joint_backlash", "joint_b", 0.005)).keys() == {
        ("clock_drift", "joint_b")
    }
    assert told(found("wheelbase", "a", 0.9), found("slip_patch", "b.left", 0.01)).keys() == {
        ("wheelbase", "a")
    }


def test_a_slip_on_one_side_of_what_is_unknown_on_both_trucks_is_no_more_than_possible():
    probabilities = told(found("unknown", "left", 0.75), found("slip_patch", "a.left", 0.19))
    assert probabilities["unknown", "left"] == pytest.approx(0.99)
    assert probabilities["slip_patch", "a.left"] < 0.1


def test_two_findings_of_their_own_strength_both_stand():
    assert set(told(found("wheelbase", "a", 0.5), found("wheel_diameter", "b.left", 0.5)).values()) == {0.99}


def test_a_patch_where_a_wheel_is_about_to_lose_counts_is_of_that_making():
    losing = found("count_loss", "b.left", 1.0)
    assert told(losing, found("slip_patch", "b.left", 0.03)).keys() == {("count_loss", "b.left")}
    assert len(told(losing, found("slip_patch", "b.right", 0.03))) == 2


def test_a_patch_beside_a_bump_is_of_its_making_and_one_elsewhere_is_not():
    bump = found("bump", "b.right", 0.8, intervals=((10.0, 10.3),))
    assert told(bump, found("slip_patch", "b.right", 0.05, intervals=((10.2, 10.8),))).keys() == {
        ("bump", "b.right")
    }
    assert len(told(bump, found("slip_patch", "b.right", 0.05, intervals=((20.0, 20.6),)))) == 2


def test_a_crowd_of_bumps_and_slips_under_both_wheels_is_something_that_shoves_the_truck():
    events = (("bump", "b.left"), ("slip_patch", "b.left"), ("slip_patch", "b.right"))
    crowd = [
        found(effect, wheel, 0.2, intervals=((10.0 * at, 10.0 * at + 1.0),))
        for at, (effect, wheel) in enumerate(events, 1)
    ]
    (shoved,) = believed(crowd, REFINED, 1e4)
    assert (shoved.effect, shoved.component) == ("unknown", "b")
    assert 0.5 < shoved.probability < 0.9
    assert shoved.where.intervals == ((10.0, 11.0), (20.0, 21.0), (30.0, 31.0))
    assert {(one.effect, one.component) for one in shoved.alternatives} == set(events)
    assert len(believed(crowd[:2], REFINED, 1e4)) == 2


def test_bumps_again_and_again_under_both_wheels_of_one_truck_are_no_bumps():
    spans = tuple((10.0 * at, 10.0 * at + 0.3) for at in range(1, 5))
    later = tuple((start + 4.0, end + 4.0) for start, end in spans)
    left, right = (
        found("bump", "b.left", 0.4, intervals=spans),
        found("bump", "b.right", 0.4, intervals=later),
    )
    (shoved,) = believed([left, right], REFINED, 1e4)
    assert (shoved.effect, shoved.component) == ("unknown", "b")
    across = found("bump", "b.right", 0.4, intervals=tuple((start + 0.4, end + 0.4) for start, end in spans))
    assert len(believed([left, across], REFINED, 1e4)) == 2
    assert len(believed([left, found("bump", "a.left", 0.4, intervals=spans)], REFINED, 1e4)) == 2


def test_of_what_is_unknown_on_one_truck_the_strongest_is_told():
    assert told(found("unknown", "a", 0.6), found("unknown", "a.left", 0.2)).keys() == {("unknown", "a")}
    assert len(told(found("unknown", "a", 0.6), found("unknown", "b.left", 0.2))) == 2


def test_what_the_law_of_a_big_effect_leaves_on_its_truck_is_not_unknown():
    big, rest = found("lateral_slip", "a", 0.9), found("unknown", "joint_a", 0.07)
    assert told(big, rest).keys() == {("lateral_slip", "a")}
    assert len(told(big, found("unknown", "joint_b", 0.07))) == 2


def test_a_named_effect_that_the_unknown_could_replace_is_no_more_than_possible():
    named, curve = found("wheel_diameter", "a.left", 0.93), found("unknown", "a.left", 0.07)
    assert told(named, curve).keys() == {("wheel_diameter", "a.left")}
    probabilities = told(named, curve, dispensable={("wheel_diameter", "a.left")})
    assert probabilities["wheel_diameter", "a.left"] < 0.5 < probabilities["unknown", "a.left"]


@pytest.mark.parametrize(("effect", "doubted"), [("floor_slope", False), ("traction_slip", True)])
def test_one_floor_under_both_trucks_is_no_pair_that_cancels(effect, doubted):
    chance = np.random.default_rng(1)
    white = chance.normal(size=(1000, 1)) @ np.array([[1.0, -1.0]])
    terms = [SimpleNamespace(key=(effect, one), effect=effect, component=one) for one in "ab"]
    refined = SimpleNamespace(
        regression=SimpleNamespace(white=white),
        terms=terms,
        values=(np.array([3.0]), np.array([3.0])),
        places=(slice(0, 1), slice(1, 2)),
    )
    answers = believed([found(effect, one, 0.5) for one in "ab"], refined, 1e4)
    assert [one.probability < 0.5 for one in answers] == [doubted, doubted]


@pytest.mark.parametrize(("value", "there"), [(1.0, True), (0.2, False), (-1.0, False)])
def test_an_effect_that_the_fit_leaves_nothing_of_is_none(value, there):
    one = SimpleNamespace(positive=True)
    refined = SimpleNamespace(terms=(one,), values=(np.array([value]),), covariances=(np.array([[0.01]]),))
    assert is_something(refined, 0) is there
