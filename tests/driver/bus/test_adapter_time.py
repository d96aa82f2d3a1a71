"""Adapter stamps: a frame that the host reads late has the time at which it was on the bus."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.driver.bus.adapter_time import LEARNING, AdapterTime

PERIOD = 0.005


def heard(delays, *, offset=0.0, rate=1.0, stamp_of=None):
    """Return for frames that are read so late [s] when they were on the bus, by the truth and as told [s]."""
    adapter = AdapterTime()
    pairs, read = [], 0.0
    for number, delay in enumerate(delays):
        true = 100.0 + PERIOD * number
        read = max(read, true + delay)
        stamp = true * rate + offset if stamp_of is None else stamp_of(true)
        pairs.append((true, adapter.heard(stamp, read), read))
    return pairs


delays = st.lists(st.floats(0.0, 0.4), min_size=300, max_size=500)


@given(delays, st.sampled_from([1.0, 5000.0, 1.7e9]), st.floats(0.9999, 1.0001))
def test_a_busy_host_does_not_change_the_times_once_the_stamps_are_known(late, offset, rate):
    quick = [0.0005] * 260
    pairs = heard([*quick, *late[:100], *quick], offset=offset, rate=rate)
    for true, told, read in pairs:
        assert told <= read
        if true > 100.0 + LEARNING + 0.1:
            assert told == pytest.approx(true + 0.0005, abs=0.001)


@given(delays)
def test_no_frame_is_told_to_come_after_it_was_read_nor_long_before(late):
    assert all(read - 0.5 <= told <= read for _, told, read in heard(late, offset=7.0))


@pytest.mark.parametrize(
    "stamp_of",
    [
        lambda _true: 0.0,
        lambda _true: 1.0,
        lambda _true: math.nan,
        lambda _true: math.inf,
        lambda true: 1000.0 * true,
        lambda true: true // 1.0 + 1e6 * (true % 1.0),
    ],
    ids=["none", "standing", "nan", "inf", "milliseconds", "nonsense"],
)
def test_stamps_that_do_not_go_on_like_the_hosts_time_are_not_believed(stamp_of):
    assert all(told == read for _, told, read in heard([0.001, 0.2] * 300, stamp_of=stamp_of))


@pytest.mark.parametrize("jump", [-60.0, 60.0])
def test_after_a_jump_the_stamps_are_learned_anew(jump):
    pairs = heard([0.001] * 2000, stamp_of=lambda true: true + 1000.0 + jump * (true > 105.0))
    assert all(told == pytest.approx(read, abs=1e-9) for _, told, read in pairs)
    late = heard([*[0.001] * 1900, 0.2], stamp_of=lambda true: true + 1000.0 + jump * (true > 105.0))
    assert late[-1][1] == pytest.approx(late[-1][0] + 0.001, abs=1e-9)
