"""A node floods the bus where it sends more than three unexpected frames for each SYNC."""

from __future__ import annotations

import pytest

from omnimate.driver.robot.event_log import EventLog
from omnimate.driver.robot.flooding import FACTOR, FloodWatch
from omnimate.driver.robot.node_counts import NodeCounts


@pytest.fixture
def counts():
    return {1: NodeCounts()}


def drive(counts, can_id, per_sync, syncs=100, period=0.01):
    """Return the events of so many SYNCs, with so many frames of an identifier before each."""
    events = EventLog()
    watch = FloodWatch(counts, events)
    for sync in range(syncs):
        for _ in range(per_sync):
            watch.note(can_id)
        watch.check(period * sync)
    return [(event.node, event.what) for event in events.all()]


@pytest.mark.parametrize("per_sync", [0, 1, FACTOR - 1])
def test_up_to_the_limit_no_node_is_reported(counts, per_sync):
    assert drive(counts, 0x701, per_sync) == []


def test_above_the_limit_the_node_is_named_with_its_identifier(counts):
    assert drive(counts, 0x701, 2 * FACTOR) == [(1, "babbles: floods the bus with frames 701h")]


def test_an_identifier_of_no_node_of_the_vehicle_concerns_the_bus(counts):
    assert drive(counts, 0x3FF, 2 * FACTOR) == [(None, "babbles: floods the bus with frames 3FFh")]


@pytest.mark.parametrize("waited", [0.0, 2.0])
def test_heartbeats_of_25_ms_before_the_first_sync_and_in_a_pause_are_no_flood(counts, waited):
    events = EventLog()
    watch = FloodWatch(counts, events)
    for start in (0.0, 10.0):
        for _ in range(round(waited / 0.025)):
            watch.note(0x701)
        for sync in range(100):
            watch.check(start + waited + 0.01 * sync)
    assert events.all() == ()


def test_second_answers_to_each_sync_are_a_flood_too(counts):
    events = EventLog()
    watch = FloodWatch(counts, events)
    for sync in range(100):
        counts[1].duplicate += 2 * FACTOR
        watch.check(0.01 * sync)
    assert [event.what for event in events.all()] == [
        "babbles: floods the bus with PDOs that no SYNC asked for"
    ]


def test_the_talk_of_a_bus_that_starts_up_is_no_flood(counts):
    assert drive(counts, 0x701, 25, syncs=1) == []
