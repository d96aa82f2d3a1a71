"""What happened to a truck is left out of its noise."""

import numpy as np
import pytest

from omnimate.mismatch.noise.levels import DEFAULT_LEVELS, estimate_noise
from omnimate.mismatch.scans.disturbances import inflate_disturbed_windows
from tests.mismatch.conftest import roughness


@pytest.fixture(scope="module")
def whitened(drive, regression):
    """Return a function that gives a drive whitened with its own noise levels, whatever there is in it."""

    def of(*effects):
        own = regression(drive(*effects))
        return own.with_noise(estimate_noise(own.windows, own.raw, waves=(0.15,)))

    return of


def without_disturbances(own, start, turns):
    """Return a drive whitened with the noise of its undisturbed windows, and how many are disturbed."""
    for turn in range(turns):
        windows, count = inflate_disturbed_windows(own, own.white[:, 0])
        own = own.with_noise(estimate_noise(windows, own.raw, own.noise if turn else start, waves=(0.15,)))
    return own, count


def test_a_floor_with_a_dozen_obstacles_is_as_rough_as_without(whitened, effect):
    times = tuple(np.arange(6.0, 78.0, 6.0).tolist())
    plain = whitened()
    bumped = whitened(effect("bump", "b.left", times=times, lost=(4e-3,) * len(times)))
    assert roughness(bumped.noise) > 2.0 * roughness(plain.noise)
    bumped, count = without_disturbances(bumped, bumped.noise, 3)
    assert count >= len(times)
    assert roughness(bumped.noise) < 1.5 * roughness(plain.noise)


def test_where_nothing_happened_hardly_a_window_is_left_out(whitened):
    plain = whitened()
    windows, count = inflate_disturbed_windows(plain, plain.white[:, 0])
    assert count <= 2
    assert windows[0].rounding.shape == plain.windows[0].rounding.shape


@pytest.mark.slow
def test_what_happens_all_the_time_is_how_the_floor_is(whitened, effect):
    times = tuple(np.linspace(2.0, 78.0, 40).tolist())
    rough = whitened(effect("bump", "a.left", times=times, lost=(5e-3,) * 40))
    _, count = inflate_disturbed_windows(rough, rough.white[:, 0])
    assert count <= 0.1 * 2 * len(rough.windows[0].rounding) + 2


def test_a_long_patch_does_not_make_the_floor_rough(whitened, effect):
    plain = whitened()
    slipped = whitened(effect("slip_patch", "b.left", fraction=0.08, intervals=((30.0, 36.0),)))
    assert roughness(slipped.noise) > 2.0 * roughness(plain.noise)
    slipped, _ = without_disturbances(slipped.with_noise(DEFAULT_LEVELS), DEFAULT_LEVELS, 1)
    assert roughness(slipped.noise) < 1.5 * roughness(plain.noise)
