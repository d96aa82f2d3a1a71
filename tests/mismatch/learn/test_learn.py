"""Laws learned from leftovers that were made by known laws, by unknown ones, and by noise alone."""

import numpy as np
import pytest
from scipy.signal import lfilter

from omnimate.effects.errors import EffectError
from omnimate.effects.file import format_effects, parse_effects
from omnimate.mismatch.learn.learn import error

GAIN = 150.0  # [nat] that the true law explains: a size of 17 sigma
INSIDE = {
    "speed": lambda v: v["speed"],
    "acceleration": lambda v: v["acceleration"],
    "load": lambda v: v["load"],
    "wheel_angle": lambda v: np.cos(3.0 * v["wheel_angle"] + 0.4),
    "heading": lambda v: np.sin(2.0 * v["heading"] + 1.0),
    "time": lambda v: v["time"],
    "x": lambda v: v["x"],
    "joint_a": lambda v: v["joint_a"] ** 2,
}
OUTSIDE = {
    "step of speed": lambda v: np.tanh((v["speed"] - 0.3) / 0.05),
    "warming": lambda v: np.exp(-v["time"] / 60.0),
    "sharp in heading": lambda v: np.exp(3.0 * np.cos(v["heading"] - 1.0)),
    "fast in the joint": lambda v: np.sin(5.0 * v["joint_a"]),
    "flat spot": lambda v: np.exp(2.0 * np.cos(v["wheel_angle"])),
    "free play of the load": lambda v: np.sign(v["load"]) * np.maximum(np.abs(v["load"]) - 0.05, 0.0),
    "speed and heading": lambda v: np.tanh((v["speed"] - 0.3) / 0.05) + np.exp(np.cos(v["heading"])),
}


def recoveries(drive, laws, seeds):
    """Of each law and drive, the share of its gain that what was learned has on another drive."""
    for law in laws.values():
        for seed in seeds:
            seen, unseen = drive(seed), drive(seed + 500)
            size = seen.size(law(seen.variables), GAIN)
            found = seen.learned(size * law(seen.variables))
            yield found, unseen.recovered(found, size * law(unseen.variables))


@pytest.mark.slow
def test_laws_of_the_library_are_found_by_name_and_hold_on_another_drive(drive):
    cases = list(recoveries(drive, INSIDE, range(2)))
    assert np.mean([share >= 0.95 for _, share in cases]) >= 0.9
    names = [name for name in INSIDE for _ in range(2)]
    named = [
        name in (found.texts or [found.effects[0].over])[0]
        for name, (found, _) in zip(names, cases, strict=True)
    ]
    assert np.mean(named) >= 0.8


def test_a_curve_beyond_what_a_law_may_be_is_cut(drive):
    """A wheel cannot roll the other way by more than it turns."""
    seen = drive(1)
    [curve, *_] = seen.learned(2.0 * OUTSIDE["flat spot"](seen.variables), scale=1.0).effects
    assert curve.over
    assert np.abs(curve.ordinates).max() == 1.0


@pytest.mark.slow
def test_of_laws_outside_the_library_four_in_five_are_recovered_to_four_fifths_on_another_drive(drive):
    shares = [share for _, share in recoveries(drive, OUTSIDE, range(3))]
    assert np.mean([share >= 0.8 for share in shares]) >= 0.8


def test_what_is_learned_predicts_unseen_folds_better_than_nothing_and_as_well_as_it_says(drive):
    world = drive(3)
    law = world.variables["speed"]
    found = world.learned(world.size(law, GAIN) * law)
    assert 0.6 * GAIN < found.total < 1.4 * GAIN
    assert found.total > 3.0 * error(found.gain)


@pytest.mark.slow
def test_of_100_recordings_with_noise_alone_at_most_one_per_cent_give_a_law(drive):
    false = 0
    for seed in range(10):
        world, rng = drive(seed), np.random.default_rng(seed + 900)
        false += sum(
            world.learned(noise=rng.standard_normal(len(world.noise))) is not None for _ in range(10)
        )
    assert false <= 1


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["twice as large", "coloured", "heavy-tailed"])
def test_noise_that_is_not_as_assumed_is_no_law_either(drive, kind):
    false = 0
    for seed in range(20):
        rng, world = np.random.default_rng(seed), drive(seed)
        noise = 2.0 * world.noise
        if kind == "coloured":
            noise = lfilter([0.8], [1.0, -0.6], world.noise)
        if kind == "heavy-tailed":
            noise = rng.standard_t(3, len(noise))
        false += world.learned(noise=noise) is not None
    assert false <= 1


@pytest.mark.slow
def test_a_coefficient_is_as_far_from_the_truth_as_the_noise_lets_it_be(drive):
    away = []
    for seed in range(12):
        world = drive(seed)
        law = world.variables["acceleration"]
        size = world.size(law, GAIN)
        found = world.learned(size * law)
        assert found.texts[0] == "acceleration"
        away.append((found.coefficients[0] / size - 1.0) * np.sqrt(2.0 * GAIN))
    assert 0.4 < np.sqrt(np.mean(np.square(away))) < 1.6


def test_a_fold_in_which_the_robot_stands_says_nothing_and_does_no_harm(drive):
    world = drive(4)
    world.travel = np.where(world.variables["time"] < 60.0, 0.0, world.travel)
    law = world.variables["acceleration"]
    found = world.learned(world.size(law, GAIN) * law)
    assert found.texts == ("acceleration",)
    assert found.gain[0] == pytest.approx(0.0, abs=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["speed", "step of speed", "speed and heading"])
def test_the_units_of_variables_and_of_the_law_do_not_matter(drive, name):
    law = {**INSIDE, **OUTSIDE}[name]
    world = drive(1)
    f = world.size(law(world.variables), 4.0 * GAIN) * law(world.variables)
    metric = world.learned(f)
    values = sum(effect.value(world.variables) for effect in metric.effects)
    columns = world.columns
    world.columns = lambda basis: columns(1e-3 * basis)  # the law in per mille
    world.variables = {
        key: signal * (1.0 if key in {"heading", "wheel_angle", "joint_a"} else 1e3)
        for key, signal in world.variables.items()
    }
    small = world.learned(1e3 * f, scale=2.0)
    assert small.total == pytest.approx(metric.total, rel=1e-3)
    again = sum(effect.value(world.variables) for effect in small.effects)
    assert again == pytest.approx(1e3 * values, abs=1e-3 * np.abs(1e3 * values).max())


@pytest.mark.parametrize("name", ["speed", "sharp in heading", "speed and heading"])
def test_a_learned_law_is_an_effect_that_a_file_holds(drive, name):
    world = drive(2)
    f = {**INSIDE, **OUTSIDE}[name](world.variables)
    found = world.learned(world.size(f, 4.0 * GAIN) * f)
    assert parse_effects(format_effects(found.effects)) == found.effects
    assert len(found.coefficients) == len(found.texts)


def test_a_law_of_the_wrong_component_or_of_too_few_folds_is_refused(drive):
    world = drive(0)
    with pytest.raises(EffectError, match="expected one of travel"):
        world.learned(acts_on="yaw")
    with pytest.raises(EffectError, match="variable 'wheel_angle'"):
        world.learned(component="a", acts_on="yaw")
    world.variables["speed"] = np.where(world.variables["time"] > 5.0, np.nan, 0.0)
    with pytest.raises(ValueError, match="variable speed is not finite"):
        world.learned()
    other = drive(0)
    other.folds = other.folds // 4
    with pytest.raises(ValueError, match="2 folds; expected at least 3"):
        other.learned()
