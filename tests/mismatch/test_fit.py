"""Effects as they fit best, and what of the data they explain."""

from dataclasses import replace

import numpy as np
import pytest

from omnimate.mismatch.candidates.terms import term
from omnimate.mismatch.fit import fitted
from omnimate.mismatch.recording.signals import signals_of
from tests.mismatch.conftest import USUAL


def fit_of(recording, single, value):
    return fitted([signals_of(recording)], USUAL, [single], [np.array([value])], turns=0)


def test_what_a_linear_effect_explains_is_its_column_times_its_size(drive):
    fit = fit_of(drive(laps=1), term("wheel_diameter", "a.left"), 0.2)
    column = fit.regression.white[:, fit.chosen.places[0].start]
    np.testing.assert_allclose(fit.part, 0.2 * column, atol=0.02 * np.abs(0.2 * column).max())


@pytest.mark.parametrize("component", ["link", "joint_b"])
def test_data_with_what_a_delay_explains_is_no_noisier_for_the_delay(drive, component):
    """The column of a delay holds what wheels round off; added to the data, it would explain itself."""
    recording = drive(laps=1)
    healthy, delayed = (fit_of(recording, term("latency", component), delay) for delay in (0.0, 2.0))
    plain = healthy.regression.white[:, 0] + healthy.part
    whole = delayed.regression.white[:, 0] + delayed.part
    assert whole @ whole == pytest.approx(plain @ plain, rel=1e-3)


def with_reversals_at_rest(recording, channel, travel):
    """Return a recording at whose end a motor goes back and forth by a travel [m], while the robot stands."""
    vehicle, count = recording.vehicle, 800
    gone = np.tile(np.repeat([0.0, travel], 20), count // 40) / vehicle.metres_per_count(channel)
    counts = np.repeat(recording.counts[-1:], count, axis=0)
    counts[:, vehicle.channels.index(channel)] -= np.rint(gone).astype(np.int64)
    later = recording.time[-1] + (recording.time[1] - recording.time[0]) * np.arange(1, count + 1)
    return replace(
        recording,
        time=np.concatenate([recording.time, later]),
        counts=np.vstack([recording.counts, counts]),
        present=np.vstack([recording.present, np.ones_like(counts, bool)]),
        commands=None,
        run=None,
    )


def test_a_play_beyond_all_reversals_is_as_sure_as_what_it_explains_and_as_uncertain_as_it_is_flat(drive):
    """A motor reverses by 2 mm in its play: any play of 2 mm or more explains it, and 3.5 mm is kept."""
    signals = [signals_of(with_reversals_at_rest(drive(laps=1), "a.left", 2e-3))]
    play = term("gear_backlash", "a.left")
    without, wide = (fitted(signals, USUAL, [play], [np.array([size])]) for size in (0.0, 7.0))
    assert wide.chosen.values[0] == pytest.approx(7.0)
    assert wide.chosen.covariance[0, 0] > 1.0
    assert wide.squared_deviations()[0] > 1000.0
    assert np.sum(wide.rows[:, 0] ** 2) == pytest.approx(np.sum(without.rows[:, 0] ** 2), rel=0.01)
