"""Columns of effects: what a robot with one of them would have shown otherwise."""

import numpy as np
import pytest

from omnimate.mismatch.candidates.pushes import Push
from omnimate.mismatch.recording.response import brief_column, column, response
from omnimate.mismatch.recording.signals import signals_of
from omnimate.mismatch.recording.windows import windows_of


@pytest.fixture(scope="module")
def windows(drive):
    return windows_of(signals_of(drive()))


@pytest.fixture(scope="module")
def base(effect):
    return [
        effect("wheel_diameter", "a.left", ratio=1.01),
        effect("wheelbase", "b", ratio=0.99),
        effect("turn_scrub", "a", slope=0.001),
        effect("joint_bias", "joint_a", bias=0.01),
    ]


def brief_effects(effect, windows):
    begin = float(windows.time[len(windows.time) // 2]) + 0.03
    return {
        "bump": effect("bump", "a.right", times=(begin,), lost=(0.004,)),
        "slip": effect("slip_patch", "b.left", fraction=0.1, intervals=((begin, begin + 3.3),)),
        "push": Push("b", begin, 2.0, ((0.001, -0.002, 0.003), (0.002, 0.001, -0.001))),
        "before": effect("bump", "a.right", times=(windows.time[0] - 5.0,), lost=(0.004,)),
        "after": effect("bump", "a.right", times=(windows.time[-1] + 5.0,), lost=(0.004,)),
    }


@pytest.mark.parametrize("name", ["bump", "slip", "push", "after"])
def test_a_column_by_the_steps_in_which_an_effect_acts_is_that_by_all_steps(name, effect, windows, base):
    single = brief_effects(effect, windows)[name]
    during = single.acts_during(windows.signals.block)
    brief = brief_column(windows, base, single, 0.5, during)
    whole = column(response(windows, base), response(windows, [*base, single]), 0.5)
    assert (np.abs(whole[0]).max() > 1e-4) == (name != "after")
    for mine, expected in zip(brief, whole, strict=True):
        assert mine == pytest.approx(expected, abs=1e-6)


def test_the_column_of_an_effect_that_ends_is_made_from_a_few_windows(effect, windows):
    single = brief_effects(effect, windows)["bump"]
    inputs, _ = brief_column(windows, [], single, 1.0, single.acts_during(windows.signals.block))
    assert 1 <= np.count_nonzero(np.abs(inputs).max(axis=1)) <= 4
