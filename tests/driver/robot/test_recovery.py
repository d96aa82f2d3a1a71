"""Nodes that lost their configuration are configured again, one at a time, with longer and longer pauses."""

import can
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.driver.canopen.node_setup import NodeConfiguration
from omnimate.driver.errors import BusLost, NodeMissing
from omnimate.driver.robot.events import EventLog
from omnimate.driver.robot.recovery import FIRST_DELAY, LONGEST_DELAY, Recovery


class Script:
    """Fails to configure a node so many times."""

    def __init__(self, failures=0, error=None):
        self.failures, self.error, self.asked = failures, error or NodeMissing(1, ["a.left"]), []

    def __call__(self, node):
        self.asked.append(node)
        if self.failures:
            self.failures -= 1
            raise self.error
        return NodeConfiguration(node, ("a.left",))


def run(recovery, until, step=0.25):
    """Poll at equal intervals; return the time and the node of each configuration."""
    done, now = [], 0.0
    while now < until:
        configuration = recovery.poll(now)
        if configuration is not None:
            done.append((now, configuration.node))
        now += step
    return done


def test_nodes_are_configured_one_at_a_time_in_the_order_of_their_requests():
    recovery = Recovery(Script(), EventLog(), inline=True)
    for node in (3, 1, 2):
        recovery.request(node, 0.0)
    assert [node for _, node in run(recovery, 1.0)] == [3, 1, 2]


@given(st.integers(0, 20))
def test_a_requested_node_is_configured_at_once_or_tried_with_doubled_pauses_up_to_the_longest(failures):
    script, events = Script(failures), EventLog()
    recovery = Recovery(script, events, inline=True)
    assert not recovery.is_busy
    recovery.request(1, 0.0)
    assert recovery.is_busy
    pauses = [min(FIRST_DELAY * 2**number, LONGEST_DELAY) for number in range(failures)]
    assert run(recovery, sum(pauses) + 1.0) == [(sum(pauses), 1)]
    assert not recovery.is_busy
    assert sum(event.count for event in events.all()) == failures


def test_a_failing_node_does_not_hold_up_another():
    configured = []

    def configure(node):
        if node == 1:
            raise NodeMissing(1, ["a.left"])
        configured.append(node)
        return NodeConfiguration(node, ("a.right",))

    recovery = Recovery(configure, EventLog(), inline=True)
    recovery.request(1, 0.0)
    recovery.request(2, 0.0)
    assert run(recovery, 5.0, step=0.1) == [(0.1, 2)]
    assert recovery.is_busy


def test_a_bus_that_is_lost_in_an_inline_dialogue_is_the_drivers_matter():
    recovery = Recovery(Script(1, BusLost(can.CanOperationError("down"))), EventLog(), inline=True)
    recovery.request(1, 0.0)
    with pytest.raises(BusLost):
        recovery.poll(0.0)


def test_a_bus_that_is_lost_in_a_thread_is_tried_again():
    events = EventLog()
    recovery = Recovery(Script(1, BusLost(can.CanOperationError("down"))), events, inline=False)
    recovery.request(1, 0.0)
    now, configuration = 0.0, None
    while configuration is None and now < 1e6:
        configuration, now = recovery.poll(now), now + 0.25
    recovery.close()
    assert configuration is not None
    assert [event.what for event in events.all()] == [
        "could not be configured again, tried until it can: the bus was lost"
    ]


@pytest.mark.parametrize("inline", [True, False])
def test_a_node_that_is_requested_while_it_is_configured_is_configured_again(inline):
    """It may have lost what was written so far, as with its power."""
    asked = []

    def configure(node):
        asked.append(node)
        if len(asked) == 1:
            recovery.request(node, 0.0)
        return NodeConfiguration(node, ("a.left",))

    recovery = Recovery(configure, EventLog(), inline=inline)
    recovery.request(1, 0.0)
    polls = 0
    while recovery.is_busy and polls < 1e6:
        recovery.poll(0.0)
        polls += 1
    recovery.close()
    assert asked == [1, 1]
