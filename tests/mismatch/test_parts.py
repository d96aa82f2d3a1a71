"""Parts of the method: each can be left out, and only it."""

import numpy as np
import pytest

from omnimate.mismatch import diagnose
from omnimate.mismatch.noise import STILL, WHITE_FLOOR, estimate_noise
from omnimate.mismatch.parts import ABLATIONS, WHOLE, Parts
from omnimate.mismatch.regression import Regression
from omnimate.mismatch.signals import signals_of
from omnimate.mismatch.windows import windows_of


@pytest.fixture(scope="module")
def worn(drive, effect):
    return drive(effect("wheel_diameter", "a.left", ratio=1.004))


def test_each_ablation_leaves_out_one_part():
    for parts in ABLATIONS.values():
        assert sum(getattr(parts, name) != getattr(WHOLE, name) for name in Parts.__slots__) == 1


def test_a_white_floor_stays_white(worn):
    windows = [windows_of(signals_of(worn))]
    columns = Regression(windows, WHITE_FLOOR, (), [np.zeros(len(windows[0].ends), int)]).raw
    noise = estimate_noise(windows, columns, WHITE_FLOOR)
    assert noise.waviness == pytest.approx(STILL)
    assert noise.roughness != pytest.approx(WHITE_FLOOR.roughness)


def test_effects_act_on_readings_as_read_where_none_are_foreseen(worn):
    signals = signals_of(worn, foreseen=False)
    np.testing.assert_array_equal(signals.block.reading, signals.reading[1:])
    assert np.abs(signals_of(worn).block.reading - signals.reading[1:]).max() > 0.0


def test_without_the_unknown_and_refinement_a_worn_wheel_is_named(worn):
    findings = diagnose([worn], parts=Parts(unknown=False, refinement=False)).findings
    assert [(one.effect, one.component) for one in findings] == [("wheel_diameter", "a.left")]


def test_what_has_no_name_is_not_unknown_where_that_is_left_out(worn):
    gone = ["wheel_diameter", "radius_vs_speed", "count_loss", "radius_step"]
    findings = diagnose([worn], without=gone, parts=Parts(unknown=False)).findings
    assert "unknown" not in {one.effect for one in findings}
