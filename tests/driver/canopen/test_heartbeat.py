"""The heartbeat is set where it is off or unreasonable, left where it is not, and never fatal."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.driver.canopen.heartbeat import (
    DRIVE_HEARTBEAT_MS,
    HEARTBEAT_MS,
    LONGEST_MS,
    SHORTEST_MS,
    set_heartbeat,
)
from omnimate.driver.canopen.notes import Notes


@pytest.mark.parametrize(
    ("wanted", "longest"), [(HEARTBEAT_MS, LONGEST_MS), (DRIVE_HEARTBEAT_MS, DRIVE_HEARTBEAT_MS)]
)
@given(before=st.integers(0, 0xFFFF))
def test_the_period_is_within_the_bounds_afterwards_and_only_changed_where_it_was_not(
    kit, before, wanted, longest
):
    device, notes = kit.encoder_device(1), Notes()
    device.objects[0x1017, 0][0] = before
    period = set_heartbeat(kit.sdo([device])[0], notes, wanted, longest)
    after = device.objects[0x1017, 0][0]
    assert SHORTEST_MS <= after <= longest
    assert period == after / 1000.0
    assert (after == before) == (SHORTEST_MS <= before <= longest)
    assert bool(notes.changed) == (after != before)


@pytest.mark.parametrize(("before", "period"), [(0, None), (5, 0.005), (5000, 5.0)])
def test_a_refusal_leaves_the_period_as_it_is_with_a_remark(kit, before, period):
    device, notes = kit.encoder_device(1), Notes()
    device.objects[0x1017, 0][0] = before
    device.refuse[0x1017, 0] = 0x06010002
    assert set_heartbeat(kit.sdo([device])[0], notes) == period
    assert "read-only" in notes.remarks[0]


def test_a_device_without_a_heartbeat_is_remarked(kit):
    device, notes = kit.encoder_device(1), Notes()
    del device.objects[0x1017, 0]
    assert set_heartbeat(kit.sdo([device])[0], notes) is None
    assert "1017h" in notes.remarks[0]
