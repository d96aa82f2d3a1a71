"""What stands in the place of names that are not believed."""

import pytest

from omnimate.mismatch.diagnosis import Change, Finding, Fit
from omnimate.mismatch.instead import contradicted, dwarfed, gathered, nameless

FINDINGS = (Finding("wheel_diameter", "a.left", 0.98), Finding("unknown", "a", 0.9))


def fit(after):
    return Fit("", Change(1.1, 1.0), Change(1.1, 1.0), rerun={"a position": Change(0.01, after)})


@pytest.mark.parametrize("after", [0.004, 0.010, 0.011])
def test_effects_that_lead_nearer_or_as_near_keep_their_probability(after):
    assert contradicted(FINDINGS, fit(after)) == FINDINGS


def test_what_explains_less_than_half_of_what_nobody_does_is_a_possibility(found):
    small, large = found("link_scale", "link", 0.02), found("slip_patch", "b.right", 0.6)
    assert dwarfed([small, large], 0.03) == (small, large)
    doubted, kept = dwarfed([small, large], 0.06)
    assert kept == large
    assert doubted.probability < 0.5


def test_effects_that_lead_farther_astray_become_possibilities_and_the_unknown_stays():
    named, unknown = contradicted(FINDINGS, fit(0.015))
    assert named.probability == pytest.approx(0.98 / 1.5**2)
    assert unknown == FINDINGS[1]


def test_where_the_strongest_is_contradicted_something_unknown_acts(found):
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


def test_a_crowd_of_bumps_and_slips_under_both_wheels_is_something_that_shoves_the_truck(found):
    events = (("bump", "b.left"), ("slip_patch", "b.left"), ("slip_patch", "b.right"))
    crowd = [
        found(effect, wheel, 0.2, intervals=((10.0 * at, 10.0 * at + 1.0),))
        for at, (effect, wheel) in enumerate(events, 1)
    ]
    (shoved,) = gathered(crowd)
    assert (shoved.effect, shoved.component) == ("unknown", "b")
    assert 0.5 < shoved.probability < 0.9
    assert shoved.where.intervals == ((10.0, 11.0), (20.0, 21.0), (30.0, 31.0))
    assert {(one.effect, one.component) for one in shoved.alternatives} == set(events)
    assert len(gathered(crowd[:2])) == 2


def test_bumps_again_and_again_under_both_wheels_of_one_truck_are_no_bumps(found):
    spans = tuple((10.0 * at, 10.0 * at + 0.3) for at in range(1, 5))
    later = tuple((start + 4.0, end + 4.0) for start, end in spans)
    left, right = (
        found("bump", "b.left", 0.4, intervals=spans),
        found("bump", "b.right", 0.4, intervals=later),
    )
    (shoved,) = gathered([left, right])
    assert (shoved.effect, shoved.component) == ("unknown", "b")
    across = found("bump", "b.right", 0.4, intervals=tuple((start + 0.4, end + 0.4) for start, end in spans))
    assert len(gathered([left, across])) == 2
    assert len(gathered([left, found("bump", "a.left", 0.4, intervals=spans)])) == 2


def test_what_else_is_unknown_and_much_weaker_is_how_the_strongest_looks_from_elsewhere(found):
    strong, weak = found("unknown", "b", 0.6), found("unknown", "joint_a", 0.1)
    kept, doubted = dwarfed([strong, weak], 0.0)
    assert kept == strong
    assert doubted.probability < 0.5
    other = found("unknown", "joint_a", 0.3)
    assert dwarfed([strong, other], 0.0) == (strong, other)


def test_what_shoves_a_truck_is_one_with_what_else_is_unknown_on_it(found):
    spans = tuple((10.0 * at, 10.0 * at + 0.3) for at in range(1, 5))
    later = tuple((start + 4.0, end + 4.0) for start, end in spans)
    crowd = found("bump", "b.left", 0.3, intervals=spans), found("bump", "b.right", 0.3, intervals=later)
    (both,) = gathered([found("unknown", "b", 0.2), *crowd])
    assert (both.probability, both.explained) == (0.99, pytest.approx(0.8))
    assert len(gathered([found("unknown", "a", 0.2), *crowd])) == 2


def test_where_no_name_is_believed_something_unknown_acts_on_the_truck(found):
    bump = found("bump", "b.left", 0.001, intervals=((20.0, 20.3),))
    patch = found("slip_patch", "b.right", 0.002, probability=0.7, intervals=((10.0, 12.0),))
    one = nameless([bump, patch, found("link_scale", "link", 0.002)], "b")
    assert (one.effect, one.component, one.probability) == ("unknown", "b", 0.99)
    assert one.where.intervals == ((10.0, 12.0), (20.0, 20.3))
    assert not nameless([found("link_scale", "link", 0.002)], "b").where.intervals
