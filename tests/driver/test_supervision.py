from __future__ import annotations

import pytest

from driver.events import MAX_EVENTS, EventLog
from driver.supervision import Supervision


@pytest.fixture
def events():
    return EventLog()


@pytest.fixture
def supervision(events):
    watched = Supervision([1], events)
    watched.started(1, 0.5)
    return watched


def test_before_the_first_heartbeat_nothing_is_lost(supervision, events):
    supervision.check(1e6)
    assert events.all() == ()


def test_three_periods_without_one_are_a_loss(supervision, events):
    supervision.heartbeat(1, b"\x05", 10.0)
    supervision.check(11.5)
    assert not supervision.lost
    supervision.check(11.6)
    supervision.check(11.7)
    assert supervision.lost == {1}
    assert [(event.time, event.what) for event in events.all()] == [(11.6, "heartbeat lost: none for 1.5 s")]


def test_a_pause_of_the_bus_is_not_held_against_the_nodes(supervision, events):
    supervision.heartbeat(1, b"\x05", 10.0)
    supervision.pause(5.0)
    supervision.check(16.0)
    assert events.all() == ()


def test_a_boot_up_of_a_node_that_was_not_started_is_no_restart(events):
    watched = Supervision([1], events)
    watched.heartbeat(1, b"\x00", 1.0)
    assert watched.restarted == set()
    assert watched.nodes[1].boots == 1


def test_one_boot_up_is_one_restart(supervision):
    supervision.heartbeat(1, b"\x00", 1.0)
    supervision.heartbeat(1, b"\x00", 1.1)
    assert supervision.restarted == {1}
    assert supervision.nodes[1].restarts == 1


def test_node_guarding_toggle_is_no_other_state(supervision):
    assert supervision.heartbeat(1, b"\x85", 1.0)
    assert supervision.nodes[1].state == 5


@pytest.mark.parametrize("data", [b"", b"\x05\x05"])
def test_what_is_no_heartbeat_is_said_to_be_none(supervision, data):
    assert not supervision.heartbeat(1, data, 1.0)


def test_what_is_no_emcy_is_said_to_be_none(supervision):
    assert not supervision.emergency(1, b"\x10\x81", 1.0)


def test_a_status_word_without_fault_is_nothing(supervision):
    supervision.status_words[0x191] = 1
    for data in (b"\x37\x02", b"\x08", b""):
        supervision.status_word(0x191, data, 1.0)
    assert supervision.lost == set()
    supervision.status_word(0x191, b"\x08\x00", 1.0)
    assert supervision.lost == {1}


def test_repeated_words_are_one_event_that_counts(events):
    for time in (1.0, 2.0, 5.0):
        events.add(time, 1, "same")
    (event,) = events.all()
    assert (event.time, event.last, event.count) == (1.0, 5.0, 3)


def test_the_log_is_bounded(events):
    for number in range(MAX_EVENTS + 10):
        events.add(float(number), None, f"event {number}")
    assert len(events.all()) == MAX_EVENTS
    assert events.dropped == 10
