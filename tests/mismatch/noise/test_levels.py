"""The levels of noise, estimated from the recordings themselves."""

from dataclasses import fields, replace

import numpy as np
import pytest

from omnimate.mismatch.candidates.regression import Regression
from omnimate.mismatch.candidates.terms import term
from omnimate.mismatch.noise import levels
from omnimate.mismatch.noise.levels import DEFAULT_LEVELS, NoiseLevels, estimate_noise, filter_of, variance_of
from omnimate.mismatch.recording.signals import signals_of
from omnimate.mismatch.recording.windows import windows_of
from tests.mismatch.conftest import roughness

TRUE = NoiseLevels(4e-4, 1e-4, 0.15, 1e-3, 4e-4, 6e-4, 3e-4, 1.4, 0.8)
MOVED = 1e-4  # of a level's logarithm


@pytest.fixture(scope="module")
def windows(drive, watched):
    return windows_of(signals_of(watched(drive(laps=1))))


def drawn(windows, noise, seed):
    """Return windows whose measurements are drawn from the model at some levels, with white noise only."""
    chance = np.random.default_rng(seed)
    run, states = filter_of(windows, noise), windows.transition.shape[1]
    _, process, _ = levels._motion(windows, noise)
    variance = variance_of(windows, noise)
    state = np.zeros(states)
    measured = np.full(windows.measured.shape, np.nan)
    for moment, size in enumerate(variance):
        if moment:
            push = chance.multivariate_normal(np.zeros(states), process[moment - 1], method="svd")
            state = run.transition[moment - 1] @ state + push
        measured[moment] = windows.observe[moment] @ state + np.sqrt(size) * chance.normal(size=len(size))
    return replace(windows, measured=measured, drift=np.zeros_like(windows.drift))


def columns(windows, *terms):
    built = Regression([windows], DEFAULT_LEVELS, ())
    built.add(terms)
    return built.raw


def left(windows, noise):
    """Return the chi-square that levels leave for each row."""
    white = Regression(windows, noise, ()).white[:, 0]
    return float(white @ white) / len(white)


@pytest.mark.parametrize("nuisances", [(), (term("wheel_diameter", "a.left"), term("joint_bias", "joint_b"))])
def test_the_slopes_of_the_likelihood_are_its_differences(windows, nuisances):
    raw = columns(windows, *nuisances)
    _, slopes = levels._negative_log_likelihood([windows], raw, TRUE)
    for number, field in enumerate(fields(NoiseLevels)):
        if field.name == "wave":
            continue  # one of a few lengths; none is in between
        value = getattr(TRUE, field.name)
        high, low = (
            levels._negative_log_likelihood(
                [windows], raw, replace(TRUE, **{field.name: value * np.exp(sign * MOVED)})
            )[0]
            for sign in (1.0, -1.0)
        )
        difference = (high - low) / (2.0 * MOVED)
        # the slope by the waves leaves out how large they are when the recording begins
        close = 2e-3 if field.name == "waviness" else 1e-5
        assert slopes[number] == pytest.approx(difference, rel=close, abs=1e-3), field.name


@pytest.mark.parametrize("seed", range(3))
def test_levels_of_white_noise_are_found_within_a_factor_of_one_and_a_half(windows, seed):
    noisy = drawn(windows, TRUE, seed)
    found = estimate_noise([noisy], columns(noisy), waves=(TRUE.wave,))
    assert roughness(found) == pytest.approx(roughness(TRUE), rel=0.5)
    for name in ("roughness", "creep", "joint_a", "joint_b", "link", "position", "heading"):
        assert 1.0 / 1.5 < getattr(found, name) / getattr(TRUE, name) < 1.5, name


def test_levels_are_as_large_where_nuisances_take_half_of_few_readings(windows):
    chance, found = np.random.default_rng(3), []
    for seed in range(6):
        noisy = drawn(windows, TRUE, seed)
        kept = np.linspace(0, len(noisy.measured) - 1, 24).astype(int)
        few = np.full_like(noisy.measured, np.nan)
        few[kept, noisy.linkage :] = noisy.measured[kept, noisy.linkage :]
        few = replace(noisy, measured=few)
        push, seen = columns(few)[0]
        curves = np.cumsum(chance.normal(size=(*push.shape[:2], 36)), axis=0) / 10.0
        raw = [(np.concatenate((push, curves), axis=2), np.pad(seen, ((0, 0), (0, 0), (0, 36))))]
        found.append(estimate_noise([few], raw, waves=(TRUE.wave,)).roughness / TRUE.roughness)
    assert 0.7 < float(np.exp(np.mean(np.log(found)))) < 1.5


def test_a_large_effect_that_is_a_nuisance_changes_no_level(windows):
    large = term("wheel_diameter", "a.left")
    noisy = drawn(windows, TRUE, 7)
    push, seen = columns(noisy, large)[0]
    plain = estimate_noise([noisy], [(push, seen)], waves=(TRUE.wave,))
    push, seen = push.copy(), seen.copy()
    push[..., 0] += 3.0 * push[..., 1]
    seen[..., 0] += 3.0 * seen[..., 1]
    with_effect = estimate_noise([noisy], [(push, seen)], waves=(TRUE.wave,))
    np.testing.assert_allclose(with_effect.levels(), plain.levels(), atol=0.1)


@pytest.mark.parametrize(
    ("name", "component", "values"),
    [("wheel_diameter", "a.left", {"ratio": 1.03}), ("joint_bias", "joint_a", {"bias": 0.03})],
)
def test_a_robot_with_a_large_effect_in_it_looks_no_quieter(drive, effect, name, component, values):
    healthy, ill = (
        windows_of(signals_of(drive(*effects, laps=1)))
        for effects in ((), (effect(name, component, **values),))
    )
    plain, with_effect = (
        estimate_noise([own], columns(own, term(name, component)), waves=(0.15,)) for own in (healthy, ill)
    )
    assert roughness(with_effect) > roughness(plain) / 1.25


def test_the_levels_make_what_is_left_as_large_as_they_say(windows):
    healthy = [drawn(windows, TRUE, 5)]
    raw = columns(healthy[0])
    usual = estimate_noise(healthy, raw, waves=(0.15,))
    assert left(healthy, usual) == pytest.approx(1.0, abs=0.1)
    trapped = replace(DEFAULT_LEVELS, joint_a=1e-9, joint_b=1e-9, link=1e-9)
    again = estimate_noise(healthy, raw, trapped, waves=(0.15,))
    assert roughness(again) == pytest.approx(roughness(usual), rel=0.2)
    assert left(healthy, again) == pytest.approx(1.0, abs=0.1)


def test_a_robot_without_noise_is_not_believed_to_have_none(windows):
    quiet = replace(windows, measured=np.zeros_like(windows.measured), drift=np.zeros_like(windows.drift))
    noise = estimate_noise([quiet], columns(quiet), waves=(0.15,))
    assert noise.roughness >= DEFAULT_LEVELS.roughness / 3.01


def test_a_healthy_drive_leaves_white_innovations(drive, regression):
    """On the simulator's floor and encoders, which are not drawn from the filter's model."""
    own = regression(drive())
    own = own.with_noise(estimate_noise(own.windows, own.raw, waves=(0.15,)))
    for channel in range(own.windows[0].linkage):
        rows = own.white[own.channel == channel, 0]
        assert np.mean(rows**2) == pytest.approx(1.0, abs=0.2)
        for late in (1, 2, 3):
            alike = float(rows[late:] @ rows[:-late]) / float(rows @ rows)
            assert abs(alike) < 4.0 / np.sqrt(len(rows)), (channel, late)


def test_the_variance_open_loop_is_that_of_drawn_motion_and_of_the_sensors_at_both_ends(windows):
    edges = 0, len(windows.ends) // 2
    ends = np.array([drawn(windows, TRUE, seed).measured[edges[1]] for seed in range(60)])
    variance = variance_of(windows, TRUE)
    both_ends = variance[edges[0]] + variance[edges[1]]
    motion = levels.open_loop_variance(windows, TRUE, edges)[0] - both_ends
    assert ends.var(axis=0) == pytest.approx(motion + variance[edges[1]], rel=0.5)
    assert (motion > 0.0).all()
