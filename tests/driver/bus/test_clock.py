from __future__ import annotations

import pytest

from omnimate.driver.bus import clock as module
from omnimate.driver.bus.clock import SyncClock, WallClock


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
        times.append(clock.heard(host.now))
    assert times[:3] == pytest.approx([7.000001, 7.000002, 7.000003], abs=1e-9)
    assert times == sorted(times)
    assert times[-1] == clock.now() < 7.015
    assert clock.sync() == pytest.approx(7.015)
    assert clock.now() == pytest.approx(7.015)


def test_sync_clock_waits_for_answers_in_host_time(host):
    clock = SyncClock(0.015, window=0.5)
    clock.sync()
    assert clock.remaining() == pytest.approx(0.5)
    host.now += 0.6
    assert clock.remaining() < 0.0
    assert clock.due() == 0.0
