"""Moments of events: settled to the sample, and as sure as they say."""

import numpy as np
import pytest

from omnimate.mismatch.candidates.terms import term
from omnimate.mismatch.scans.nonlinear import lasts, refine, spreads

TRUE = (20.0, 55.0)


@pytest.fixture(scope="module")
def bumped(drive, effect, regression):
    """Return a function that gives a drive over two bumps, whitened."""

    def of(lost):
        return regression(drive(effect("bump", "b.right", times=TRUE, lost=(lost, lost))))

    return of


@pytest.mark.parametrize("start", [19.8, 20.3])
def test_a_moment_is_settled_within_what_it_is_said_to_be_unsure(bumped, alone, start):
    own = bumped(4e-3)
    found = refine(own, alone(own), term("bump", "b.right", times=(start,)))
    (loose,) = spreads(own, found, np.array([4.0]))["times"]
    assert loose < 0.05
    assert abs(found.fixed["times"][0] - TRUE[0]) < max(4.0 * loose, 0.15)


def test_a_moment_of_a_smaller_bump_is_less_sure(bumped):
    own = bumped(4e-3)
    bumps = term("bump", "b.right", times=TRUE)
    large, small = (spreads(own, bumps, np.full(2, size))["times"] for size in (4.0, 1.0))
    assert min(small) > 1.2 * max(large)


def test_a_stretch_is_settled_to_its_ends(drive, effect, regression, alone):
    true = (23.3, 31.1)
    own = regression(drive(effect("slip_patch", "a.right", fraction=0.08, intervals=(true,))))
    found = refine(own, alone(own), term("slip_patch", "a.right", intervals=((22.0, 33.5),)))
    assert found.fixed["intervals"][0] == pytest.approx(true, abs=0.3)


def test_a_step_of_a_radius_is_told_from_turns_on_both_of_its_sides(bumped, alone):
    own = bumped(4e-3)
    time = own.windows[0].time
    middle, late = 0.5 * (time[0] + time[-1]), time[-1] - 4.0
    assert lasts(own, term("radius_step", "a.left", time=middle))
    assert not lasts(own, term("radius_step", "a.left", time=late))
    found = refine(own, alone(own), term("radius_step", "a.left", time=late - 18.0))
    assert lasts(own, found)


def test_what_has_no_moment_is_left_as_it_is(bumped, alone):
    own = bumped(4e-3)
    plain = term("wheel_diameter", "a.left")
    assert refine(own, alone(own), plain) is plain
    assert spreads(own, plain, np.ones(1)) == {}
