"""Moments of events: settled to the sample, as sure as they say, and none that is not there."""

import numpy as np
import pytest

from omnimate.mismatch.folds import folds_of
from omnimate.mismatch.moments import firm, lasts, looseness, met, settle
from omnimate.mismatch.noise import DEFAULT_LEVELS
from omnimate.mismatch.regression import Regression
from omnimate.mismatch.signals import signals_of
from omnimate.mismatch.terms import term
from omnimate.mismatch.windows import windows_of

TRUE = (20.0, 55.0)


@pytest.fixture(scope="module")
def bumped(drive, effect):
    """Return a function that gives a drive over two bumps, whitened, every sample about them measured."""

    def regression(lost):
        recording = drive(effect("bump", "b.right", times=TRUE, lost=(lost, lost)))
        windows = [windows_of(signals_of(recording), [(at - 0.6, at + 0.6) for at in TRUE])]
        return Regression(windows, DEFAULT_LEVELS, (), folds_of(windows))

    return regression


def test_moments_are_settled_within_what_they_are_said_to_be_unsure(bumped):
    regression = bumped(3e-3)
    (settled,) = settle(regression, [term("bump", "b.right", times=(19.8, 55.2))])
    (loose,) = looseness(regression, [settled])
    assert len(loose["times"]) == 2
    off = np.abs(np.subtract(settled.fixed["times"], TRUE)) / loose["times"]
    assert off.max() < 4.0
    assert max(loose["times"]) < 0.05


def test_a_moment_of_a_smaller_bump_is_less_sure(bumped):
    (large,), (small,) = (
        looseness(bumped(lost), [term("bump", "b.right", times=TRUE)]) for lost in (3e-3, 1e-3)
    )
    assert min(small["times"]) > 1.5 * max(large["times"])


def test_a_bump_that_is_not_there_is_left_out_and_columns_are_as_before(bumped):
    regression = bumped(3e-3)
    before = regression.white.shape
    (kept,) = firm(regression, [term("bump", "b.right", times=(*TRUE, 40.0))])
    assert kept.fixed["times"] == TRUE
    assert regression.white.shape == before


def test_a_wheel_that_stands_meets_an_obstacle_when_it_rolls_on(bumped):
    regression = bumped(3e-3)
    block = regression.windows[0].signals.block
    stands = block.travel[:, 3] == 0.0
    assert stands[0]
    first = int(np.argmin(stands))
    rolls = float(block.time[first] - block.period[first])
    assert met(regression, "b.right", rolls - 0.05) == pytest.approx(rolls)
    assert met(regression, "b.right", TRUE[0]) == TRUE[0]


def test_two_moments_near_one_bump_are_one_bump(bumped):
    regression = bumped(3e-3)
    (settled,) = firm(regression, settle(regression, [term("bump", "b.right", times=(19.97, 20.03, 55.2))]))
    assert settled.fixed["times"] == pytest.approx(TRUE, abs=0.05)


def test_a_bump_finds_its_place_though_another_one_stands_where_none_is(bumped):
    (settled,) = settle(bumped(3e-3), [term("bump", "b.right", times=(20.3, 37.0, 54.8))])
    assert min(abs(time - TRUE[0]) for time in settled.fixed["times"]) < 0.05
    assert min(abs(time - TRUE[1]) for time in settled.fixed["times"]) < 0.05


def test_a_step_of_a_radius_is_told_from_turns_on_both_of_its_sides(bumped):
    regression = bumped(3e-3)
    time = regression.windows[0].time
    middle, late = 0.5 * (time[0] + time[-1]), time[-1] - 4.0
    assert lasts(regression, term("radius_step", "a.left", time=middle))
    assert not lasts(regression, term("radius_step", "a.left", time=late))
    (settled,) = settle(regression, [term("radius_step", "a.left", time=late - 12.0)])
    assert lasts(regression, settled)
