"""A restarted counter's lost travel: taken from the other wheel, alike live and offline."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omnimate.vehicle.bridging import Bridges, bridge
from omnimate.vehicle.counters import Counter, CounterLaw, unwrap
from omnimate.vehicle.file import parse_vehicle

ROUNDING = 4  # counts: of both wheels, at both ends of the gap
LAW = CounterLaw((2**32,), 100_000, absolute=False)


@pytest.fixture(scope="module")
def vehicle():
    same = "start_bit = 0, bits = 32, signed = true"
    return parse_vehicle(f"""
    truck.a = {{wheelbase = 0.34, wheel_diameter_left = 0.15, wheel_diameter_right = 0.15}}
    bus = {{bitrate = 500000, sync_period = 0.015}}
    encoder = [
      {{channel = "a.left", node = 1, cob_id = 0x181, {same}, sign = 1, counts_per_turn = 40000}},
      {{channel = "a.right", node = 2, cob_id = 0x182, {same}, sign = -1, counts_per_turn = 20000}},
    ]
    """)


def offline(vehicle, raw, present, restarts):
    columns = [unwrap(raw[:, one], LAW, present[:, one], restarts[:, one]) for one in (0, 1)]
    counts, seen, rebased = (
        np.stack([getattr(column, name) for column in columns], axis=1)
        for name in ("counts", "present", "rebased")
    )
    bridge(vehicle, counts, seen, rebased)
    return counts


def live(vehicle, raw, present, restarts):
    counters, bridges = [Counter(LAW), Counter(LAW)], Bridges(vehicle)
    rows = []
    for index in range(len(raw)):
        believed = []
        for column, counter in enumerate(counters):
            if restarts[index, column]:
                counter.rebase()
            believed.append(counter.step(int(raw[index, column]) if present[index, column] else None))
        bridges.follow(counters, believed)
        rows.append([counter.count for counter in counters])
    return rows


def restarted(truth, present, column, at):
    """Return raw readings whose counter in `column` begins anew at row `at`, and the restarts."""
    raw, restarts = truth.copy(), np.zeros(truth.shape, bool)
    raw[at:, column] -= truth[at, column]
    restarts[at, column] = True
    return raw, restarts


@given(st.integers(-400, 400), st.floats(-3, 3), st.integers(0, 1), st.integers(1, 40))
def test_driving_at_a_constant_proportion_loses_nothing(vehicle, speed, ratio, column, gap):
    """A straight, an arc or a turn on the spot: the restarted wheel ends within a count of the truth."""
    steps = np.arange(120)
    truth = np.stack([steps * speed, np.round(-steps * speed * ratio / 2)], axis=1).astype(np.int64)
    present = np.ones(truth.shape, bool)
    present[50 : 50 + gap, column] = False
    raw, restarts = restarted(truth, present, column, 50 + gap)
    found = offline(vehicle, raw, present, restarts)
    still = abs(truth[1, 1 - column]) * (2, 1)[column] * 4 < abs(truth[1, column]) * (1, 2)[column]
    lost = abs(int(truth[50 + gap, column] - truth[49, column]))
    error = np.abs(found[-1, column] - truth[-1, column])
    assert error <= lost + ROUNDING, "never worse than what the lost samples explain"
    if not still and abs(truth[1, 1 - column]) > 25:
        assert error <= 0.01 * lost + ROUNDING, "rounding of the proportion only"


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1))
def test_live_and_offline_agree_whatever_is_missing_or_restarts(vehicle, seed):
    random = np.random.default_rng(seed)
    truth = np.cumsum(random.integers(-300, 500, (150, 2)), axis=0)
    present = random.random(truth.shape) > 0.2
    present[:3] = True
    restarts = random.random(truth.shape) < 0.03
    restarts[:3] = False
    raw = truth.copy()
    for row, column in np.argwhere(restarts):
        raw[row:, column] = truth[row:, column] - truth[row, column]
    assert offline(vehicle, raw, present, restarts).tolist() == live(vehicle, raw, present, restarts)


def test_a_standing_robot_loses_nothing_and_both_wheels_at_once_stay_where_they_were(vehicle):
    truth = np.tile([5000, -900], (30, 1))
    present = np.ones(truth.shape, bool)
    raw, restarts = restarted(truth, present, 0, 20)
    assert offline(vehicle, raw, present, restarts).tolist() == truth.tolist()
    moving = np.stack([np.arange(30) * 10, -np.arange(30) * 5], axis=1)
    raw, restarts = moving.copy(), np.zeros(moving.shape, bool)
    raw[20:] -= moving[20]
    restarts[20] = True
    assert offline(vehicle, raw, present, restarts)[20].tolist() == moving[19].tolist()
