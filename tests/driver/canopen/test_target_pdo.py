"""The RPDO of a drive: what stands where."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.driver.canopen.pdo_mapping import Entry
from omnimate.driver.canopen.target_pdo import (
    CONTROL_WORD,
    FILLER,
    MODE,
    TARGET_VELOCITY,
    TargetPdo,
    planned_pdo,
    takes_target,
)
from omnimate.vehicle.errors import TableError
from omnimate.vehicle.parameters import Drive

orders = st.permutations([CONTROL_WORD, TARGET_VELOCITY, FILLER])


@given(orders, st.integers(-(2**31), 2**31 - 1), st.integers(0, 0xFFFF))
def test_target_and_control_word_stand_where_the_mapping_says(entries, target, control):
    pdo = TargetPdo(0x201, tuple(entries))
    data = pdo.data(target, control)
    assert len(data) == 7
    word = int.from_bytes(data, "little")
    assert (word >> pdo.start_bit & 0xFFFFFFFF) == target % 2**32
    before = entries[: entries.index(CONTROL_WORD)]
    assert word >> sum(entry.bits for entry in before) & 0xFFFF == control


@pytest.mark.parametrize("start_bit", [0, 8, 16, 24, 32])
def test_what_is_planned_has_the_target_where_vehicle_toml_says(start_bit):
    pdo = planned_pdo(Drive("a.left", 1, 0x201, 1, 4096, start_bit=start_bit))
    assert pdo.start_bit == start_bit
    assert takes_target(pdo.entries)


@pytest.mark.parametrize(
    ("entries", "taken"),
    [
        ((TARGET_VELOCITY,), True),
        ((CONTROL_WORD, MODE, TARGET_VELOCITY), True),
        ((CONTROL_WORD,), False),
        ((), False),
        ((TARGET_VELOCITY, TARGET_VELOCITY), False),
        ((TARGET_VELOCITY, Entry(0x6071, 0, 16)), False),
        ((Entry(0x60FF, 0, 16), CONTROL_WORD), False),
    ],
)
def test_a_mapping_is_taken_where_every_entry_can_be_sent(entries, taken):
    assert takes_target(entries) is taken


@pytest.mark.parametrize("start_bit", [4, 33, -8])
def test_a_target_begins_at_a_byte(start_bit):
    with pytest.raises(TableError, match="start_bit"):
        Drive("a.left", 1, 0x201, 1, 4096, start_bit=start_bit)
