"""Patches are proposed where they are, not where a grid of stretches happens to lie."""

import pytest

from omnimate.mismatch.choose import EMPTY, Choice
from omnimate.mismatch.folds import folds_of
from omnimate.mismatch.leftover import leftover
from omnimate.mismatch.noise import DEFAULT_LEVELS
from omnimate.mismatch.patches import patches
from omnimate.mismatch.regression import Regression
from omnimate.mismatch.signals import WINDOW, signals_of
from omnimate.mismatch.windows import windows_of


@pytest.mark.parametrize("true", [(23.3, 31.1), (40.7, 44.9)])
def test_the_best_proposal_is_a_window_or_two_from_the_truth(drive, effect, true):
    recording = drive(effect("slip_patch", "a.right", fraction=0.08, intervals=(true,)))
    windows = [windows_of(signals_of(recording))]
    regression = Regression(windows, DEFAULT_LEVELS, (), folds_of(windows))
    left = leftover(regression, Choice([], [], regression.total), EMPTY)
    near = [
        max(abs(start - true[0]), abs(end - true[1]))
        for one in patches(regression, [left])
        if one.component == "a.right"
        for start, end in one.fixed["intervals"]
    ]
    assert min(near) <= 3.0 * WINDOW
