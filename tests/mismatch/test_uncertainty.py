"""Stated uncertainties hold what the data leave open, and that no law is exact."""

import math

import numpy as np
import pytest

from omnimate.mismatch.terms import term
from omnimate.mismatch.uncertainty import INEXACT, LOOSER, sigmas


def told(name, component, coefficient, variance, **fixed):
    one = term(name, component, **fixed)
    built = one.built(np.full(len(one.probes), coefficient))
    return one, built, sigmas(one, built, variance * np.eye(len(one.probes)))


def test_a_small_effect_is_as_sure_as_the_data_make_it():
    one, _, known = told("wheel_diameter", "a.left", 0.0, 0.01)
    scale = one.probes[0].ratio - 1.0
    assert known == {"ratio": pytest.approx(0.1 * scale)}


@pytest.mark.parametrize(("name", "component"), [("wheel_diameter", "a.left"), ("castor_kick", "a")])
def test_a_large_one_is_no_surer_than_its_law(name, component):
    one, built, known = told(name, component, 4.0, 1e-12)
    value = getattr(built, one.linear)
    away = value - (1.0 if one.linear == "ratio" else 0.0)
    assert known[one.linear] == pytest.approx(LOOSER.get(name, INEXACT) * away)


def test_a_wave_has_both_in_its_size_and_in_its_phase():
    _, built, known = told("wheel_eccentricity", "a.left", 2.0, 0.04)
    law = LOOSER["wheel_eccentricity"]
    size = math.sqrt(8.0)
    assert known["phase"] == pytest.approx(math.hypot(0.2 / size, law))
    assert known["amplitude"] == pytest.approx(built.amplitude * math.hypot(0.2 / size, law))


def test_every_bump_has_its_own():
    _, built, known = told("bump", "a.left", 1.0, 1e-12, times=(1.0, 2.0, 3.0))
    assert known["lost"] == pytest.approx(LOOSER["bump"] * np.array(built.lost))
