"""A calibration counts as much as the recordings need it."""

import pytest

from omnimate.mismatch.answer.averaged import averaged
from omnimate.mismatch.candidates.terms import smooth_terms
from omnimate.mismatch.fit import fitted
from omnimate.mismatch.recording.signals import signals_of
from tests.mismatch.conftest import USUAL


@pytest.fixture(scope="module")
def calibrated(drive, watched, effect):
    """Return a function that gives a wheelbase that is wrong by a part, as fitted, and averaged."""

    def of(part, sigma, seed=4):
        wrong = effect("wheelbase", "a", ratio=1.0 + part)
        recording = watched(drive(wrong, seed=seed, laps=1), sigma=sigma)
        fit = fitted([signals_of(recording)], USUAL, (), ())
        number = [term.key for term in fit.calibrated.terms].index(("wheelbase", "a"))
        both = (fit.calibrated, averaged(fit))
        return [
            (float(acting.values[number][0]), float(acting.covariances()[number][0, 0])) for acting in both
        ]

    return of


@pytest.mark.slow
def test_where_the_recording_needs_it_it_is_as_fitted(calibrated):
    (fitted_size, fitted_variance), (size, variance) = calibrated(0.01, 2e-3)
    assert size == pytest.approx(fitted_size, rel=1e-3)
    assert variance == pytest.approx(fitted_variance, rel=1e-2)


def test_where_it_hardly_tells_the_robot_stays_more_as_it_is_described(calibrated):
    (_, fitted_variance), (size, variance) = calibrated(0.0, 0.1, seed=7)
    assert variance < 0.5 * fitted_variance
    assert abs(size) < variance**0.5


def test_beside_a_wheel_of_the_set_the_other_of_its_axle_is_weighed_too(drive, watched, effect):
    recording = watched(drive(effect("wheel_diameter", "a.left", ratio=1.003), laps=1), sigma=2e-3)
    signals = [signals_of(recording)]
    left = next(term for term in smooth_terms(signals) if term.key == ("wheel_diameter", "a.left"))
    fit = fitted(signals, USUAL, [left], [[0.3]])
    number = [term.key for term in fit.calibrated.terms].index(("wheel_diameter", "a.right"))
    size, most = averaged(fit).values[number][0], fit.calibrated.values[number][0]
    assert 0.0 < size / most <= 1.0


@pytest.mark.parametrize("part", [-2e-4, 1e-4, 3e-4])
def test_the_stated_sigma_of_a_number_holds_its_true_value_however_near_it_is(calibrated, part):
    _, (size, variance) = calibrated(part, 2e-3)
    assert abs(size - part / 0.01) < 3.0 * variance**0.5
    assert variance**0.5 > 0.01
