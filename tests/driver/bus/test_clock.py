import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.driver.bus import clock as module
from omnimate.driver.bus.clock import ANSWER_WINDOW, LEARNING_TIME, AdapterTime, SyncClock, WallClock

PERIOD = 0.005


def heard(delays, *, offset=0.0, rate=1.0, stamp_of=None):
    """Return for frames that are read so late [s] when they were on the bus, by the truth and as told [s]."""
    adapter = AdapterTime()
    pairs, read = [], 0.0
    for number, delay in enumerate(delays):
        true = 100.0 + PERIOD * number
        read = max(read, true + delay)
        stamp = true * rate + offset if stamp_of is None else stamp_of(true)
        pairs.append((true, adapter.host_time(stamp, read), read))
    return pairs


delays = st.lists(st.floats(0.0, 0.4), min_size=300, max_size=500)


@given(delays, st.sampled_from([1.0, 5000.0, 1.7e9]), st.floats(0.9999, 1.0001))
def test_a_busy_host_does_not_change_the_times_once_the_stamps_are_known(late, offset, rate):
    quick = [0.0005] * 260
    pairs = heard([*quick, *late[:100], *quick], offset=offset, rate=rate)
    for true, told, read in pairs:
        assert told <= read
        if true > 100.0 + LEARNING_TIME + 0.1:
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


@pytest.fixture
def host(monkeypatch):
    """Host time that a test moves by hand."""

    class Host:
        now = 50.0
        wall = 1000.0

        def monotonic(self):
            return self.now

        def time(self):
            return self.wall + self.now

    host = Host()
    monkeypatch.setattr(module, "time", host)
    return host


def test_wall_clock_paces_from_its_first_sync(host):
    clock = WallClock(0.01)
    assert clock.due() <= 0.0
    assert clock.sync() == pytest.approx(1050.0)
    assert clock.due() == pytest.approx(0.01)
    host.now += 0.004
    assert clock.remaining() == pytest.approx(0.006)
    assert clock.now() == pytest.approx(1050.004)


def test_a_late_sync_does_not_move_the_next_one(host):
    clock = WallClock(0.01)
    clock.sync()
    host.now += 0.012
    clock.sync()
    assert clock.due() == pytest.approx(0.008)
    assert clock.skipped == 0


def test_periods_that_passed_are_skipped_not_made_up(host):
    clock = WallClock(0.01)
    clock.sync()
    host.now += 0.055
    clock.sync()
    assert clock.skipped == 4
    assert clock.due() == pytest.approx(0.005)


def test_a_clock_adjustment_does_not_move_the_recording(host):
    clock = WallClock(0.01)
    first = clock.sync()
    host.wall += 3600.0
    host.now += 0.01
    assert clock.sync() - first == pytest.approx(0.01)


def test_sync_clock_counts_periods_whatever_the_host_does(host):
    clock = SyncClock(0.015, start=7.0)
    times = []
    for _ in range(4):
        times.append(clock.sync())
        host.now += 123.0
    assert times == pytest.approx([7.0, 7.015, 7.03, 7.045])


def test_times_between_syncs_stay_below_the_next_one(host):
    clock = SyncClock(0.015, start=7.0)
    clock.sync()
    times = []
    for _ in range(20_000):
        host.now += 0.001
        times.append(clock.frame_time(host.now))
    assert times[:3] == pytest.approx([7.000001, 7.000002, 7.000003], abs=1e-9)
    assert times == sorted(times)
    assert times[-1] == clock.now() < 7.015
    assert clock.sync() == pytest.approx(7.015)
    assert clock.now() == pytest.approx(7.015)


def test_sync_clock_waits_for_answers_in_host_time(host):
    clock = SyncClock(0.015)
    clock.sync()
    assert clock.remaining() == pytest.approx(ANSWER_WINDOW)
    host.now += 1.2 * ANSWER_WINDOW
    assert clock.remaining() < 0.0
    assert clock.due() == 0.0
