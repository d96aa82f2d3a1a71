"""Effects as they fit best, and only those that are told."""

import numpy as np
import pytest

from omnimate.mismatch.folds import folds_of
from omnimate.mismatch.heldout import size
from omnimate.mismatch.investigate import investigate
from omnimate.mismatch.refine import keeping, refine
from omnimate.mismatch.signals import signals_of
from omnimate.mismatch.windows import windows_of


@pytest.fixture(scope="module")
def found(drive, effect):
    both = effect("wheelbase", "b", ratio=1.02), effect("wheel_diameter", "a.left", ratio=1.004)
    windows = [windows_of(signals_of(drive(*both)))]
    return investigate(windows, folds_of(windows))


def test_effects_that_are_not_told_leave_the_fit_and_the_others_are_fitted_anew(found):
    whole = refine(found)
    assert {one.name for one in whole.effects} == {"wheelbase", "wheel_diameter"}
    assert keeping(found, whole, [one.key for one in whole.terms], 2) is whole
    part = keeping(found, whole, [("wheelbase", "b")], 2)
    (wheelbase,) = part.effects
    assert wheelbase.ratio == pytest.approx(1.02, abs=2e-3)
    nothing = keeping(found, whole, [], 2)
    assert nothing.effects == ()
    left = [size(one.regression.white[:, 0]) for one in (whole, part, nothing)]
    assert left[0] < 1.05 < left[1] < left[2]
    assert np.isfinite(left).all()
