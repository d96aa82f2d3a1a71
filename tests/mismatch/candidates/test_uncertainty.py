"""Stated uncertainties hold what the data leave open, and that no law is exact."""

import math

import numpy as np
import pytest

from omnimate.effects.effect import RECORDING_DISCREPANCY_FACTOR
from omnimate.effects.floor_slope import FILM_DISCREPANCY
from omnimate.mismatch.candidates.terms import term


def told(name, component, coefficient, variance, **fixed):
    member = term(name, component, **fixed)
    built = member.built(np.full(len(member.probes), coefficient))
    return member, built, member.sigmas(built, variance * np.eye(len(member.probes)))


def test_a_small_effect_is_as_sure_as_the_data_make_it():
    member, _, known = told("wheel_diameter", "a.left", 0.0, 0.01)
    scale = member.probes[0].ratio - 1.0
    assert known == {"ratio": pytest.approx(0.1 * scale)}


@pytest.mark.parametrize(("name", "component"), [("wheel_diameter", "a.left"), ("castor_kick", "a")])
def test_a_large_one_is_no_surer_than_its_law(name, component):
    member, built, known = told(name, component, 4.0, 1e-12)
    value = getattr(built, member.linear)
    away = value - (1.0 if member.linear == "ratio" else 0.0)
    assert known[member.linear] == pytest.approx(RECORDING_DISCREPANCY_FACTOR * member.discrepancy * away)


def test_a_wave_has_both_in_its_size_and_in_its_phase():
    member, built, known = told("wheel_eccentricity", "a.left", 2.0, 0.04)
    law = RECORDING_DISCREPANCY_FACTOR * member.discrepancy
    size = math.sqrt(8.0)
    assert known["phase"] == pytest.approx(math.hypot(0.2 / size, law))
    assert known["amplitude"] == pytest.approx(built.amplitude * math.hypot(0.2 / size, law))


def test_every_bump_has_its_own():
    member, built, known = told("bump", "a.left", 1.0, 1e-12, times=(1.0, 2.0, 3.0))
    assert known["lost"] == pytest.approx(
        RECORDING_DISCREPANCY_FACTOR * member.discrepancy * np.array(built.lost)
    )


def test_a_film_is_told_for_a_pace_that_is_a_mean():
    _, built, known = told("floor_slope", "a", 2.0, 1e-12, pace=0.2)
    assert known["rate"] == pytest.approx(FILM_DISCREPANCY * built.rate, rel=1e-3)
