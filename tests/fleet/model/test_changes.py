import math
from dataclasses import replace

import numpy as np
import pytest

from omnimate.fleet.model.changes import Change, detect_change, select_faulty
from omnimate.fleet.model.histories import History, NominalVariation, estimate_nominal_variation

NAMES = ("left wheel", "right wheel", "wheelbase")
SIGMA = np.array([7e-5, 7e-5, 7e-4])
WEAR = np.array([-1e-5, -1e-5, 0.0])


def history(seed, days=12, robot="r", added=0.0):
    """Return the history of a robot that wears as the others do, with `added` `(D, 3)` on top."""
    chance = np.random.default_rng(seed)
    start = 2.0 * SIGMA * chance.normal(size=3)
    wear = WEAR + 3e-6 * chance.normal(size=3)
    at = np.arange(float(days))
    value = start + at[:, np.newaxis] * wear + SIGMA * chance.normal(size=(days, 3)) + added
    dates = tuple(f"2026-03-{day + 1:02d}" for day in range(days))
    return History(robot, "tug", NAMES, dates, at, value, np.tile(np.diag(SIGMA**2), (days, 1, 1)))


@pytest.fixture(scope="module")
def fleet():
    return [history(seed) for seed in range(200)]


@pytest.fixture(scope="module")
def nominal(fleet):
    return estimate_nominal_variation(fleet)


def step(day, number, sigmas, days=12):
    added = np.zeros((days, 3))
    added[day:, number] = sigmas * SIGMA[number]
    return added


def test_the_nominal_variation_comes_out_of_the_fleet(nominal):
    assert nominal.sigma == pytest.approx(SIGMA)
    assert np.sqrt(nominal.start_variance) == pytest.approx(10.0 * SIGMA)  # the least that is allowed for
    assert nominal.wear[:2] == pytest.approx(WEAR[:2], abs=2e-6)
    assert np.all(np.sqrt(nominal.daily) < 0.5 * SIGMA)


def test_a_few_faulty_robots_do_not_change_the_nominal_variation(fleet, nominal):
    faulty = [history(seed, added=step(4, 0, 50.0)) for seed in range(10)]
    mixed = estimate_nominal_variation([*faulty, *fleet[10:]])
    assert mixed.start == pytest.approx(nominal.start, abs=3e-5)
    assert mixed.daily == pytest.approx(nominal.daily, abs=(0.5 * SIGMA[0]) ** 2)
    assert mixed.wear == pytest.approx(nominal.wear, abs=1e-5)


def test_of_two_robots_the_faulty_one_is_seen():
    two = [history(1), history(2, added=step(4, 2, 40.0))]
    healthy, faulty = (detect_change(robot, estimate_nominal_variation(two)) for robot in two)
    assert healthy.log_e < 5.0
    assert faulty.log_e > 15.0
    assert faulty.name == "wheelbase"


def test_the_evidence_against_healthy_robots_has_a_mean_of_one_at_most(nominal):
    values = np.exp([detect_change(history(seed), nominal).log_e for seed in range(1000, 1400)])
    assert values.mean() < 1.0 + 3.0 * values.std() / math.sqrt(len(values))
    assert values.max() < 1e3


@pytest.mark.parametrize("number", range(3))
def test_a_step_is_seen_named_dated_and_measured(nominal, number):
    change = detect_change(history(7, added=step(8, number, 10.0)), nominal)
    assert change.log_e > 15.0
    assert (change.name, change.since, change.shape) == (NAMES[number], "2026-03-09", "step")
    assert change.size == pytest.approx(10.0 * SIGMA[number], abs=4.0 * change.sigma)


def test_a_ramp_is_seen_with_its_speed(nominal):
    added = np.zeros((12, 3))
    added[6:, 2] = 4.0 * SIGMA[2] * np.arange(1, 7)
    change = detect_change(history(8, added=added), nominal)
    assert (change.name, change.shape) == ("wheelbase", "ramp")
    assert change.per_day == pytest.approx(4.0 * SIGMA[2], rel=0.3)
    assert change.earliest <= "2026-03-07" <= change.latest


def test_one_odd_day_is_no_change_and_the_second_one_is(nominal):
    once = np.zeros((12, 3))
    once[11, 0] = 40.0 * SIGMA[0]
    assert detect_change(history(9, added=once), nominal).log_e < 5.0
    assert detect_change(history(9, added=step(10, 0, 40.0)), nominal).log_e > 15.0


def test_a_robot_with_two_days_is_not_judged(nominal):
    assert detect_change(history(1, days=2), nominal) is None


def test_the_size_of_numbers_does_not_matter(nominal):
    scaled = replace(history(7, added=step(8, 0, 10.0)))
    larger = replace(scaled, value=10.0 * scaled.value, covariance=100.0 * scaled.covariance)
    variances = {"start_variance", "wear_variance", "daily"}
    times_ten = NominalVariation(
        **{
            name: (100.0 if name in variances else 10.0) * getattr(nominal, name)
            for name in NominalVariation.__slots__
        }
    )
    assert detect_change(larger, times_ten).log_e == pytest.approx(detect_change(scaled, nominal).log_e)


def named(log_e, robot="r"):
    return Change(robot, "tug", log_e, "wheelbase", 1.0, "", "", "", "step", 0.0, 1.0, 0.0)


def test_the_faulty_robots_are_those_of_e_bh():
    level, robots = 0.05, 100
    needed = [math.log(robots / (level * rank)) for rank in (1, 2, 3)]
    quiet = [named(-3.0)] * 97
    assert len(select_faulty([named(needed[0]), *quiet, *quiet[:2]], level)) == 1
    assert select_faulty([named(needed[1]), named(needed[0] - 0.01), *quiet, *quiet[:1]], level) != []
    assert select_faulty([named(needed[2] - 0.01)] * 3 + quiet, level) == []
    assert len(select_faulty([named(needed[2])] * 3 + quiet, level)) == 3
