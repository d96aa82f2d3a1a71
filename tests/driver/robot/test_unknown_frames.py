"""Frames that nothing expects are counted by kind and for the node whose identifier they carry."""

from __future__ import annotations

import can
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.driver.robot.node_counts import NodeCounts
from omnimate.driver.robot.unknown_frames import MAX_KINDS, UnknownFrames


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
    assert unknown.kinds[key].count == 2
    assert description is None or unknown.kinds[key].description == description


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
    assert sum(kind.count for kind in unknown.kinds.values()) == len(identifiers)
    with_node = [identifier for identifier in identifiers if identifier & 0x7F]
    assert sum(node.unknown for node in counts.values()) == len(with_node)


def test_a_bus_full_of_identifiers_does_not_fill_the_memory():
    unknown = UnknownFrames({})
    for identifier in range(MAX_KINDS + 100):
        unknown.count(can.Message(arbitration_id=0x10000 + identifier))
    assert len(unknown.kinds) == MAX_KINDS + 1
    assert unknown.kinds["others"].count == 100
