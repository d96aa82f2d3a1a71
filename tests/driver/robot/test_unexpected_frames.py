"""Frames that nothing expects are counted by kind and for the node whose identifier they carry."""

import can
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.driver.robot.events import EventLog, NodeCounts
from omnimate.driver.robot.unexpected_frames import BABBLING_FACTOR, MAX_KINDS, FloodDetector, UnknownFrames


@pytest.mark.parametrize(
    ("message", "key", "description"),
    [
        (can.Message(arbitration_id=0x080, is_extended_id=False), "080h", "SYNC"),
        (can.Message(arbitration_id=0x18FF1234), "18FF1234h", "29-bit identifier, not CANopen"),
        (can.Message(is_error_frame=True), "error frame", "the adapter reports an error on the bus"),
        (
            can.Message(arbitration_id=0x181, is_extended_id=False, is_remote_frame=True),
            "181h remote",
            None,
        ),
    ],
)
def test_a_frame_is_counted_under_its_identifier_and_described(message, key, description):
    unknown = UnknownFrames({})
    unknown.count(message)
    unknown.count(message)
    ((identifier, words, count),) = unknown.rows()
    assert (identifier, count) == (key, 2)
    assert description is None or words == description


def test_a_29_bit_identifier_is_never_counted_for_a_node():
    counts = {1: NodeCounts()}
    UnknownFrames(counts).count(can.Message(arbitration_id=0x18FF1201))
    assert counts[1].unknown == 0


@given(st.lists(st.integers(0, 0x7FF), max_size=200))
def test_every_frame_is_counted_in_one_kind_and_for_its_node(identifiers):
    counts = {node: NodeCounts() for node in range(1, 128)}
    unknown = UnknownFrames(counts)
    for identifier in identifiers:
        unknown.count(can.Message(arbitration_id=identifier, is_extended_id=False))
    assert sum(unknown.kinds.values()) == len(identifiers)
    with_node = [identifier for identifier in identifiers if identifier & 0x7F]
    assert sum(node.unknown for node in counts.values()) == len(with_node)


def test_a_bus_full_of_identifiers_does_not_fill_the_memory():
    unknown = UnknownFrames({})
    for identifier in range(MAX_KINDS + 100):
        unknown.count(can.Message(arbitration_id=0x10000 + identifier))
    assert len(unknown.kinds) == MAX_KINDS + 1
    assert unknown.kinds["others"] == 100


@pytest.fixture
def counts():
    return {1: NodeCounts()}


def drive(counts, can_id, per_sync, syncs=100, period=0.01):
    """Return the events of so many SYNCs, with so many frames of an identifier before each."""
    events = EventLog()
    watch = FloodDetector(counts, events)
    for sync in range(syncs):
        for _ in range(per_sync):
            watch.note(can_id)
        watch.check(period * sync)
    return [(event.node, event.what) for event in events.all()]


@pytest.mark.parametrize(
    ("can_id", "per_sync", "syncs", "nodes"),
    [
        *((0x701, per_sync, 100, []) for per_sync in (0, 1, BABBLING_FACTOR - 1)),
        (0x701, 2 * BABBLING_FACTOR, 100, [1]),
        (0x3FF, 2 * BABBLING_FACTOR, 100, [None]),  # of no node of the vehicle: it concerns the bus
        (0x701, 25, 1, []),  # the talk of a bus that starts up
    ],
)
def test_above_the_limit_the_node_is_named_with_its_identifier(counts, can_id, per_sync, syncs, nodes):
    what = f"babbles: floods the bus with frames {can_id:03X}h"
    assert drive(counts, can_id, per_sync, syncs) == [(node, what) for node in nodes]


@pytest.mark.parametrize("waited", [0.0, 2.0])
def test_heartbeats_of_25_ms_before_the_first_sync_and_in_a_pause_are_no_flood(counts, waited):
    events = EventLog()
    watch = FloodDetector(counts, events)
    for start in (0.0, 10.0):
        for _ in range(round(waited / 0.025)):
            watch.note(0x701)
        for sync in range(100):
            watch.check(start + waited + 0.01 * sync)
    assert events.all() == ()


def test_second_answers_to_each_sync_are_a_flood_too(counts):
    events = EventLog()
    watch = FloodDetector(counts, events)
    for sync in range(100):
        counts[1].duplicate += 2 * BABBLING_FACTOR
        watch.check(0.01 * sync)
    assert [event.what for event in events.all()] == [
        "babbles: floods the bus with PDOs that no SYNC asked for"
    ]


def test_two_devices_of_one_id_are_seen_after_another_master_has_ended(counts):
    """While it sends SYNC, too, every node answers twice as often."""
    watch = FloodDetector(counts, EventLog())
    duplicated = []
    for sync in range(300):
        if sync < 100:
            watch.foreign_sync()
        if sync < 100 or sync >= 200:
            counts[1].duplicate += 1
        duplicated += [(node, sync) for node in watch.check(0.01 * sync)]
    assert duplicated
    assert {node for node, _ in duplicated} == {1}
    assert min(sync for _, sync in duplicated) > 200
