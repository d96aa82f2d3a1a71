"""What is small, hollow, or of another one's making is not asserted."""

from types import SimpleNamespace

import numpy as np
import pytest

from omnimate.mismatch.doubt import believed, is_something

REFINED = SimpleNamespace(
    regression=SimpleNamespace(white=np.zeros((1000, 1))), terms=(), values=(), places=()
)


def told(*findings, dispensable=frozenset(), whole=1e4):
    answers = believed(findings, REFINED, whole, dispensable)
    return {(one.effect, one.component): one.probability for one in answers}


def test_what_explains_next_to_nothing_beside_a_stronger_one_is_not_told(found):
    assert told(found("clock_drift", "joint_b", 1.0), found("joint_backlash", "joint_b", 0.005)).keys() == {
        ("clock_drift", "joint_b")
    }
    assert told(found("wheelbase", "a", 0.9), found("slip_patch", "b.left", 0.01)).keys() == {
        ("wheelbase", "a")
    }


def test_a_slip_on_one_side_of_what_is_unknown_on_both_trucks_is_no_more_than_possible(found):
    probabilities = told(found("unknown", "left", 0.75), found("slip_patch", "a.left", 0.19))
    assert probabilities["unknown", "left"] == pytest.approx(0.99)
    assert probabilities["slip_patch", "a.left"] < 0.1


def test_what_is_plain_is_told_however_large_another_one_is(found):
    large, small = found("lateral_slip", "a", 0.99), found("wheelbase", "b", 0.002)
    assert len(told(large, small, whole=1e4)) == 1
    assert len(told(large, small, whole=1e5)) == 2
    assert len(told(large, found("slip_patch", "b.left", 0.002), whole=1e5)) == 1


def test_two_findings_of_their_own_strength_both_stand(found):
    assert set(told(found("wheelbase", "a", 0.5), found("wheel_diameter", "b.left", 0.5)).values()) == {0.99}


def test_a_patch_where_a_wheel_is_about_to_lose_counts_is_of_that_making(found):
    losing = found("count_loss", "b.left", 1.0)
    assert told(losing, found("slip_patch", "b.left", 0.03)).keys() == {("count_loss", "b.left")}
    assert len(told(losing, found("slip_patch", "b.right", 0.03))) == 2


@pytest.mark.parametrize(
    ("effect", "component"), [("slip_patch", "b.left"), ("joint_eccentricity", "joint_b")]
)
def test_what_is_weak_on_a_floor_that_slopes_is_how_it_slopes(found, effect, component):
    slope = found("floor_slope", "b", 1.0)
    assert len(told(slope, found(effect, component, 0.06))) == 1
    assert len(told(slope, found(effect, component, 0.2))) == 2
    assert len(told(slope, found("floor_slope", "a", 0.06))) == 2


def test_a_patch_beside_a_bump_is_of_its_making_and_one_elsewhere_is_not(found):
    bump = found("bump", "b.right", 0.8, intervals=((10.0, 10.3),))
    assert told(bump, found("slip_patch", "b.right", 0.05, intervals=((10.2, 10.8),))).keys() == {
        ("bump", "b.right")
    }
    assert len(told(bump, found("slip_patch", "b.right", 0.05, intervals=((20.0, 20.6),)))) == 2


def test_what_shoves_a_truck_makes_names_on_it_doubtful(found):
    spans = tuple((10.0 * at, 10.0 * at + 0.3) for at in range(1, 5))
    later = tuple((start + 4.0, end + 4.0) for start, end in spans)
    crowd = found("bump", "b.left", 0.2, intervals=spans), found("bump", "b.right", 0.2, intervals=later)
    probabilities = told(*crowd, found("wheelbase", "b", 0.5))
    assert probabilities["wheelbase", "b"] < 0.5 < probabilities["unknown", "b"]
    assert told(*crowd, found("wheelbase", "a", 0.5))["wheelbase", "a"] > 0.9


def test_of_what_is_unknown_on_one_truck_the_strongest_is_told(found):
    assert told(found("unknown", "a", 0.6), found("unknown", "a.left", 0.2)).keys() == {("unknown", "a")}
    assert len(told(found("unknown", "a", 0.6), found("unknown", "b.left", 0.2))) == 2


def test_what_the_law_of_a_big_effect_leaves_on_its_truck_is_not_unknown(found):
    big, rest = found("lateral_slip", "a", 0.9), found("unknown", "joint_a", 0.07)
    assert told(big, rest).keys() == {("lateral_slip", "a")}
    assert len(told(big, found("unknown", "joint_b", 0.07))) == 2


def test_a_named_effect_that_the_unknown_could_replace_is_no_more_than_possible(found):
    named, curve = found("wheel_diameter", "a.left", 0.93), found("unknown", "a.left", 0.07)
    assert told(named, curve).keys() == {("wheel_diameter", "a.left")}
    probabilities = told(named, curve, dispensable={("wheel_diameter", "a.left")})
    assert probabilities["wheel_diameter", "a.left"] < 0.5 < probabilities["unknown", "a.left"]


def fitted(white, *terms):
    """Return effects that were fitted, each three times as large as usual, with a column of `(V, C)` each."""
    return SimpleNamespace(
        regression=SimpleNamespace(white=white),
        terms=[SimpleNamespace(key=(name, one), effect=name, component=one) for name, one in terms],
        values=[np.array([3.0])] * len(terms),
        places=[slice(at, at + 1) for at in range(len(terms))],
    )


@pytest.mark.parametrize(("effect", "doubted"), [("floor_slope", False), ("traction_slip", True)])
def test_one_floor_under_both_trucks_is_no_pair_that_cancels(found, effect, doubted):
    chance = np.random.default_rng(1)
    white = chance.normal(size=(1000, 1)) @ np.array([[1.0, -1.0]])
    answers = believed(
        [found(effect, one, 0.5) for one in "ab"], fitted(white, (effect, "a"), (effect, "b")), 1e4
    )
    assert [one.probability < 0.5 for one in answers] == [doubted, doubted]


def test_three_large_effects_on_a_truck_that_cancel_are_something_unknown(found):
    names = ("wheel_diameter", "b.left"), ("wheel_diameter", "b.right"), ("floor_slope", "b")
    columns = np.random.default_rng(1).normal(size=(1000, 3))
    findings = [found(*one, 0.5) for one in names]
    assert believed(findings, fitted(columns, *names), 1e4) == tuple(findings)
    columns[:, 2] = -columns[:, 0] - columns[:, 1]
    unknown, *rest = sorted(
        believed(findings, fitted(columns, *names), 1e4), key=lambda one: -one.probability
    )
    assert (unknown.effect, unknown.component) == ("unknown", "b")
    assert unknown.probability > 0.5 > rest[0].probability


@pytest.mark.parametrize(("value", "there"), [(1.0, True), (0.2, False), (-1.0, False)])
def test_an_effect_that_the_fit_leaves_nothing_of_is_none(value, there):
    one = SimpleNamespace(positive=True)
    refined = SimpleNamespace(terms=(one,), values=(np.array([value]),), covariances=(np.array([[0.01]]),))
    assert is_something(refined, 0) is there
