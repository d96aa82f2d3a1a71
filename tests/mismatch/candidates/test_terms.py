"""Candidates as columns: what bends is tried at several sizes."""

import numpy as np
import pytest

from omnimate.effects import EFFECTS, effect_named
from omnimate.effects.bump import BumpEvents
from omnimate.effects.count_loss import CountLoss
from omnimate.effects.wheel_diameter import WheelDiameter
from omnimate.mismatch.candidates.terms import smooth_terms, term
from omnimate.mismatch.recording.signals import signals_of
from omnimate.mismatch.scans.events import merged


@pytest.fixture(scope="module")
def signals(drive):
    return signals_of(drive(laps=1))


@pytest.fixture(scope="module")
def shown(drive, regression):
    """Return a function from terms to the unwhitened columns of what the linkage shows, `(C, M + 1, 3)`."""

    def columns(*terms):
        own = regression(drive(laps=1))
        own.add(terms)
        return own.raw[0][1][:, :3, 1:].transpose(2, 0, 1)

    return columns


def test_a_wide_play_is_met_by_the_column_of_its_own_size(shown):
    scale = effect_named("joint_backlash").parameters[0].scale
    narrow, wide = (term("joint_backlash", "joint_b", size=size) for size in (1.0, 8.0))
    truth = shown(narrow, wide)[1] * 8.0
    np.testing.assert_allclose(np.ptp(truth[:, 1]), np.ptp(shown(narrow)[0] * 8.0), rtol=0.2)
    assert np.std(truth - 8.0 * shown(narrow)[0]) > 0.05 * 8.0 * scale
    assert wide.built(np.array([8.0])).width == pytest.approx(8.0 * scale)


def test_every_size_of_what_bends_is_a_candidate_of_its_own():
    narrow, wide = (term("gear_backlash", "a.left", size=size) for size in (1.0, 6.0))
    assert merged([narrow], [narrow, wide]) == [wide]


def test_what_does_not_bend_has_the_same_column_at_every_size(shown):
    plain, other = shown(term("joint_bias", "joint_a"), term("joint_bias", "joint_a", size=5.0))
    np.testing.assert_allclose(plain, other, atol=1e-9)


def test_a_fit_starts_at_the_size_found_and_takes_slopes_there():
    wide = term("joint_backlash", "joint_b", 3, 8.0)
    fine = wide.fine()
    assert fine.size == 1.0
    assert fine.odds == wide.odds
    assert fine.fine() is fine


@pytest.mark.parametrize("coefficients", [(1.0, 0.0), (0.0, 2.0), (-1.5, 0.7), (0.3, -0.4)])
def test_two_coefficients_of_a_wave_are_its_size_and_its_phase(shown, coefficients):
    wave = term("joint_eccentricity", "joint_a")
    built = wave.built(np.array(coefficients))
    scale = wave.probes[0].amplitude
    assert built.amplitude == pytest.approx(scale * np.hypot(*coefficients))
    assert scale * np.array(coefficients) == pytest.approx(
        built.amplitude * np.array([np.cos(built.phase), np.sin(built.phase)])
    )


def test_the_more_values_were_tried_the_lower_are_the_odds_of_each():
    assert term("count_loss", "a.left", 6, above=0.1).odds == pytest.approx(
        CountLoss.prior.log_odds - np.log(6.0)
    )
    bumps = term("bump", "a.left", 100, times=(1.0, 2.0))
    assert bumps.odds == pytest.approx(BumpEvents.prior.log_odds - 2.0 * np.log(100.0))


def test_a_law_and_what_stands_at_a_moment_are_no_smooth_candidates(signals):
    offered = {single.effect for single in smooth_terms([signals])}
    assert not offered & {"law", "bump", "slip_patch", "radius_step", "gear_harmonic"}


def test_one_name_has_candidates_of_distinct_sizes_or_thresholds_only(signals):
    told = [(single.key, single.size, tuple(single.fixed.items())) for single in smooth_terms([signals])]
    assert len(set(told)) == len(told)


def test_an_effect_is_a_candidate_also_if_it_is_added_after_the_diagnosis_was_imported(signals):
    class Novel(WheelDiameter):
        name = "novel"

    EFFECTS.append(Novel)
    try:
        assert "novel" in {candidate.effect for candidate in smooth_terms([signals])}
    finally:
        EFFECTS.remove(Novel)
