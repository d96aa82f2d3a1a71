"""NMT states and heartbeats of CiA 301, as the driver follows them."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.driver.robot.events import EventLog
from omnimate.driver.robot.supervision import Supervision

BOOT_UP, STOPPED, OPERATIONAL, PRE_OPERATIONAL = 0x00, 0x04, 0x05, 0x7F  # CiA 301


def nodes_in_trouble(supervision):
    return {trouble.node for trouble in supervision.troubles}


def restarted(supervision):
    return {trouble.node for trouble in supervision.troubles if trouble.has_restarted}


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
    assert not supervision.troubles
    supervision.check(11.6)
    supervision.check(11.7)
    assert nodes_in_trouble(supervision) == {1}
    assert restarted(supervision) == set()
    assert [(event.time, event.count, event.what) for event in events.all()] == [
        (11.6, 1, "heartbeat lost: none for 1.5 s")
    ]


def test_a_heartbeat_that_is_back_is_logged_and_may_be_lost_again(supervision, events):
    for now in (10.0, 20.0):
        supervision.heartbeat(1, b"\x05", now)
        supervision.check(now + 2.0)
    supervision.heartbeat(1, b"\x05", 30.0)
    supervision.heartbeat(1, b"\x05", 30.5)
    counts = {event.what: event.count for event in events.all()}
    assert counts == {"heartbeat lost: none for 1.5 s": 2, "heartbeat is back": 2}


def test_one_node_without_a_heartbeat_does_not_hide_another_one():
    watched = Supervision([1, 2], EventLog())
    watched.started(1, None)
    watched.started(2, 0.5)
    watched.heartbeat(2, b"\x05", 1.0)
    watched.check(3.0)
    assert nodes_in_trouble(watched) == {2}


def test_a_loss_and_a_restart_are_faults(supervision, events):
    faults = []
    events.listener = lambda _time, node, _what, *, is_fault: faults.append((node, is_fault))
    supervision.heartbeat(1, b"\x05", 1.0)
    supervision.check(3.0)
    supervision.heartbeat(1, b"\x00", 4.0)
    assert faults == [(1, True), (1, False), (1, True)], "lost, back, restarted"


@pytest.mark.parametrize("has_booted", [False, True])
def test_a_boot_up_while_the_driver_configures_a_node_is_reported_once_it_was_started_again(
    supervision, has_booted
):
    supervision.interrupted(1)
    for state in (PRE_OPERATIONAL, *([BOOT_UP] if has_booted else []), PRE_OPERATIONAL, PRE_OPERATIONAL):
        supervision.heartbeat(1, bytes([state]), 1.0)
    assert not supervision.troubles
    supervision.started(1, 0.5)
    supervision.check_boots(1, 2.0)
    assert restarted(supervision) == ({1} if has_booted else set())


def test_a_pause_of_the_bus_is_not_held_against_the_nodes(supervision, events):
    supervision.heartbeat(1, b"\x05", 10.0)
    supervision.pause(5.0, 16.0)
    supervision.check(16.0)
    assert events.all() == ()


def test_node_guarding_toggle_is_no_other_state(supervision):
    assert supervision.heartbeat(1, b"\x85", 1.0)
    assert supervision.nodes[1].state == 5


@pytest.mark.parametrize("data", [b"", b"\x05\x05"])
def test_what_is_no_heartbeat_is_said_to_be_none(supervision, data):
    assert not supervision.heartbeat(1, data, 1.0)


def test_what_is_no_emcy_is_said_to_be_none(supervision):
    assert not supervision.emergency(1, b"\x10\x81", 1.0)


@pytest.mark.parametrize("is_started", [False, True])
@pytest.mark.parametrize(
    ("heartbeats", "restarts_if_started"),
    [
        ((OPERATIONAL,), 0),
        ((OPERATIONAL,) * 10, 0),
        ((BOOT_UP,), 1),
        ((BOOT_UP, BOOT_UP), 1),
        ((BOOT_UP, PRE_OPERATIONAL, PRE_OPERATIONAL), 1),
        ((PRE_OPERATIONAL,), 0),
        ((PRE_OPERATIONAL, OPERATIONAL), 0),
        ((PRE_OPERATIONAL, OPERATIONAL, PRE_OPERATIONAL), 0),
        ((PRE_OPERATIONAL, PRE_OPERATIONAL), 1),
        ((STOPPED,), 0),
        ((STOPPED, STOPPED), 1),
        ((STOPPED, PRE_OPERATIONAL), 1),
        ((OPERATIONAL, STOPPED, STOPPED), 1),
        ((OPERATIONAL, STOPPED, STOPPED, STOPPED), 1),
    ],
)
def test_a_started_node_restarts_with_a_boot_up_or_two_states_in_a_row_that_are_not_operational(
    heartbeats, restarts_if_started, is_started
):
    watched = Supervision([1], EventLog())
    if is_started:
        watched.started(1, 0.5)
    for number, state in enumerate(heartbeats):
        assert watched.heartbeat(1, bytes([state]), 0.5 * number)
    expected = restarts_if_started if is_started else 0
    assert watched.nodes[1].restarts == expected
    assert restarted(watched) == ({1} if expected else set())
    assert watched.nodes[1].state == heartbeats[-1]
    assert watched.nodes[1].boots == heartbeats.count(BOOT_UP)
    assert watched.nodes[1].heartbeats == len(heartbeats)


def test_a_node_is_watched_again_after_it_was_started_again():
    watched = Supervision([1], EventLog())
    for restarts in (1, 2):
        watched.started(1, 0.5)
        watched.heartbeat(1, bytes([BOOT_UP]), 1.0)
        assert watched.nodes[1].restarts == restarts


def test_a_node_without_a_heartbeat_is_never_lost():
    watched = Supervision([1], EventLog())
    watched.started(1, None)
    watched.heartbeat(1, bytes([OPERATIONAL]), 1.0)
    watched.check(1e9)
    assert not watched.troubles


@given(
    period=st.floats(0.1, 2.0),
    gaps=st.lists(st.floats(0.01, 2.9), min_size=1, max_size=20),
)
def test_a_heartbeat_within_three_periods_is_never_a_loss_and_a_later_check_is_one(period, gaps):
    watched = Supervision([1], EventLog())
    watched.started(1, period)
    now = 10.0
    watched.heartbeat(1, bytes([OPERATIONAL]), now)
    for gap in gaps:
        now += gap * period
        watched.check(now)
        assert not watched.troubles
        watched.heartbeat(1, bytes([OPERATIONAL]), now)
    watched.check(now + 3.1 * period)
    assert nodes_in_trouble(watched) == {1}


def test_an_emergency_is_a_trouble_unless_it_says_that_an_error_has_gone(supervision):
    supervision.emergency(1, bytes(8), 1.0)
    assert supervision.troubles == []
    supervision.emergency(1, b"\x00\x50\x01" + bytes(5), 2.0)
    assert [(trouble.node, trouble.time, trouble.has_restarted) for trouble in supervision.troubles] == [
        (1, 2.0, False)
    ]


def test_an_emergency_is_counted_and_put_into_words():
    events = EventLog()
    watched = Supervision([1], events)
    assert watched.emergency(1, b"\x10\x81\x11" + bytes(5), 2.0)
    assert watched.nodes[1].emergencies == 1
    assert [trouble.emergency for trouble in watched.troubles] == [0x8110]
    assert [event.what for event in events.all()] == [
        "EMCY 8110h: CAN overrun, objects lost (error register 11h)"
    ]
