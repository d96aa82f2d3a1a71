"""What happened to a truck is left out of its noise."""

import numpy as np

from omnimate.mismatch.choose import EMPTY, Choice
from omnimate.mismatch.folds import folds_of
from omnimate.mismatch.leftover import leftover
from omnimate.mismatch.noise import DEFAULT_LEVELS, estimate_noise
from omnimate.mismatch.outliers import freed
from omnimate.mismatch.regression import Regression
from omnimate.mismatch.signals import signals_of
from omnimate.mismatch.windows import windows_of


def whitened(recording):
    """Return a recording whitened with its own noise levels, whatever there is in it."""
    windows = [windows_of(signals_of(recording))]
    regression = Regression(windows, DEFAULT_LEVELS, (), folds_of(windows))
    regression.whiten(estimate_noise(windows, regression.raw))
    return regression


def left_of(regression):
    return leftover(regression, Choice([], [], regression.total), EMPTY)


def roughness(noise):
    """Return how rough a floor is in all [m/sqrt(m)]: from window to window, and in waves."""
    return float(np.hypot(noise.roughness, noise.waviness))


def test_a_floor_with_a_dozen_obstacles_is_as_rough_as_without(drive, effect):
    times = tuple(np.arange(6.0, 78.0, 6.0).tolist())
    bumps = effect("bump", "b.left", times=times, lost=(4e-3,) * len(times))
    plain, bumped = whitened(drive()), whitened(drive(bumps))
    assert roughness(bumped.noise) > 2.5 * roughness(plain.noise)
    for _ in range(3):
        windows, count = freed(bumped, left_of(bumped))
        bumped.whiten(estimate_noise(windows, bumped.raw, bumped.noise))
    assert count >= len(times)
    assert roughness(bumped.noise) < 1.5 * roughness(plain.noise)


def test_where_nothing_happened_hardly_a_window_is_left_out(drive):
    regression = whitened(drive())
    windows, count = freed(regression, left_of(regression))
    assert count <= 2
    assert windows[0].rounding.shape == regression.windows[0].rounding.shape


def test_what_happens_all_the_time_is_how_the_floor_is(drive, effect):
    times = tuple(np.linspace(2.0, 78.0, 40).tolist())
    regression = whitened(drive(effect("bump", "a.left", times=times, lost=(5e-3,) * 40)))
    _, count = freed(regression, left_of(regression))
    assert count <= 0.1 * 2 * len(regression.windows[0].rounding) + 2


def test_a_long_patch_does_not_make_the_floor_rough(drive, effect):
    patch = effect("slip_patch", "b.left", fraction=0.08, intervals=((30.0, 36.0),))
    plain, slipped = whitened(drive()), whitened(drive(patch))
    assert roughness(slipped.noise) > 2.5 * roughness(plain.noise)
    slipped.whiten(DEFAULT_LEVELS)
    windows, _ = freed(slipped, left_of(slipped))
    slipped.whiten(estimate_noise(windows, slipped.raw, DEFAULT_LEVELS))
    assert roughness(slipped.noise) < 1.5 * roughness(plain.noise)
