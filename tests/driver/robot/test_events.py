"""The log of events: repetitions are counted, order is that of the first time, and the length is bounded."""

from collections import Counter

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.driver.robot.events import MAX_EVENTS, EventLog

words = st.tuples(st.sampled_from([None, 1, 2]), st.sampled_from(["lost", "back", "EMCY"]))


@pytest.fixture
def events():
    return EventLog()


def test_the_log_is_bounded_and_known_events_still_count(events):
    for number in range(MAX_EVENTS + 10):
        events.add(float(number), None, f"event {number}")
    events.add(1e6, None, "event 0")
    assert len(events.all()) == MAX_EVENTS
    assert events.dropped == 10
    assert events.all()[0].count == 2


@given(st.lists(words, max_size=50))
def test_no_event_is_lost_and_the_first_times_are_in_order(script):
    events = EventLog()
    for time, (node, what) in enumerate(script):
        events.add(float(time), node, what)
    assert {(event.node, event.what): event.count for event in events.all()} == Counter(script)
    for event in events.all():
        times = [time for time, words in enumerate(script) if words == (event.node, event.what)]
        assert (event.time, event.last) == (times[0], times[-1])
    assert [event.time for event in events.all()] == sorted(event.time for event in events.all())
