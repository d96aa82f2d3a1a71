"""The clock of a simulated robot: SYNC numbers count its own time, `pace` times as fast as the host's."""

from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.service.robot import connection as paced_clock
from omnimate.service.robot.connection import MAX_DELAY, PacedClock

PERIOD = 0.015


@pytest.fixture(scope="module")
def now():
    """A clock of the host that a test sets."""
    time = {"now": 1000.0}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(paced_clock, "time", SimpleNamespace(monotonic=lambda: time["now"]))
        yield time


@given(pace=st.floats(0.1, 1000.0), syncs=st.integers(0, 50))
def test_a_sync_is_due_when_pace_times_the_hosts_time_has_passed(now, pace, syncs):
    clock = PacedClock(PERIOD, 0.0)
    clock.set_pace(pace)
    for _ in range(syncs):
        clock.sync()
    assert clock.due() == pytest.approx(syncs * PERIOD / pace, abs=1e-9)


def test_a_change_of_pace_does_not_move_the_syncs_before_it(now):
    clock = PacedClock(PERIOD, 0.0)
    clock.sync()
    clock.set_pace(10.0)
    assert clock.due() == pytest.approx(0.0)
    clock.sync()
    assert clock.due() == pytest.approx(PERIOD / 10.0)


def test_a_long_delay_is_not_caught_up_with(now):
    clock = PacedClock(PERIOD, 0.0)
    now["now"] += MAX_DELAY + 1.0
    assert clock.due() < -MAX_DELAY
    assert clock.due() == pytest.approx(0.0)
