"""The judge of growth, and a short run of the soak.

A whole one is `python -m studies.speed.service_soak --hours 8`.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

service_soak = pytest.importorskip("studies.speed.service_soak")
PERIOD, BOUNDS, ROLES = service_soak.PERIOD, service_soak.BOUNDS, service_soak.ROLES
SEEDS = st.integers(0, 2**32 - 1)
SLOPES = st.floats(-1e4, 1e4)


def times(count):
    return [10.0 * number for number in range(count)]


@given(SLOPES, st.floats(-1e3, 1e3), st.integers(6, 200))
def test_the_slope_of_a_line_is_its_growth_in_a_period_whatever_its_level(slope, level, count):
    seconds = times(count)
    values = [level + slope * at / PERIOD for at in seconds]
    assert service_soak.slope_of(seconds, values) == pytest.approx((slope, slope), abs=1e-4)


@given(SLOPES, st.integers(40, 200), st.floats(0.0, 0.24), SEEDS)
def test_a_quarter_of_the_values_may_be_anything(slope, count, share, seed):
    rng, seconds = np.random.default_rng(seed), times(count)
    values = np.array([slope * at / PERIOD for at in seconds])
    second = np.arange(count // 2, count)
    wild = rng.choice(second, int(share * len(second)), replace=False)
    values[wild] += rng.choice([-1.0, 1.0], len(wild)) * rng.uniform(1e2, 1e6, len(wild))
    found, low = service_soak.slope_of(seconds, values)
    assert found == pytest.approx(slope, abs=1e-4)
    assert low <= found


@given(st.integers(6, 200), st.floats(0.0, 1e4), SEEDS)
def test_growth_of_the_first_half_does_not_count(count, rise, seed):
    half = count // 2
    values = [rise * number for number in range(half)] + [rise * half] * (count - half)
    assert service_soak.slope_of(times(count), values) == (0.0, 0.0)


def test_scatter_without_growth_is_not_called_growth():
    """Handles of connections that come and go, as in a short run: the slope alone would exceed the bound."""
    values = [40.0 + (number * 7) % 11 + (1.0 if number > 90 else 0.0) for number in range(118)]
    slope, low = service_soak.slope_of(times(118), values)
    assert slope > BOUNDS["handles"] > low


def test_fewer_than_three_values_have_no_slope():
    assert service_soak.slope_of(times(4), [0.0, 1.0, 2.0, 3.0]) == (0.0, 0.0)


def rows(count, growing=None, factor=0.0, pids=lambda _number: 7.0):
    """Return rows of a service in which one quantity grows by a factor of its bound."""
    found = []
    for number, seconds in enumerate(times(count)):
        row = {"seconds": seconds, "robot_pid": pids(number)}
        row |= {f"{role}_{quantity}": 50.0 for role in ROLES for quantity in BOUNDS}
        if growing is not None:
            row[growing] += factor * BOUNDS[growing.split("_")[1]] * seconds / PERIOD
        found.append(row)
    return found


@pytest.mark.parametrize("quantity", BOUNDS)
@pytest.mark.parametrize("role", ROLES)
def test_exactly_what_grows_beyond_its_bound_is_named(role, quantity):
    name = f"{role}_{quantity}"
    assert [found.name for found in service_soak.judge(rows(60, name, 1.1)) if found.grows] == [name]
    assert not [found for found in service_soak.judge(rows(60, name, 0.9)) if found.grows]


def test_a_robot_is_judged_over_its_longest_life_alone():
    """A process that was killed began again with less; neither that nor its short lives count."""
    lives = rows(60, "robot_memory", 1.1, pids=lambda number: 7.0 if number < 40 else float(number))
    for row in lives[40:]:
        row["robot_memory"] = 0.0
    assert [found.name for found in service_soak.judge(lives) if found.grows] == ["robot_memory"]


@pytest.mark.slow
def test_a_short_run_measures_each_process_and_no_call_fails_unexpectedly(tmp_path):
    found, load = service_soak.trial(tmp_path, seconds=2.0, interval=0.5, rates=(8.0, 4.0), listeners=1)
    assert all(found[0][f"{role}_{quantity}"] > 0.0 for role in ROLES for quantity in BOUNDS)
    # The robot's process is killed: calls for it are answered 503, or 409 while it is reserved.
    assert {status for _, status in load.answers} <= {200, 201, 202, 409, 503}
    assert all(status < 300 for call, status in load.answers if call.startswith("GET"))
    service_soak.write_csv(found, tmp_path / "soak.csv")
    service_soak.plot(found, tmp_path / "soak.png")
    assert len((tmp_path / "soak.csv").read_text().splitlines()) == 1 + len(found)
