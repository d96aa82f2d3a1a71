"""The power drive state machine of CiA 402."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.vcan_sim.nodes.drive import PowerState, next_state, statusword

states = st.sampled_from(PowerState)
controlwords = st.integers(0, 0xFFFF)
FAULTY = {PowerState.FAULT, PowerState.FAULT_REACTION_ACTIVE}
DISABLED, READY, ON, ENABLED = (
    PowerState.SWITCH_ON_DISABLED,
    PowerState.READY_TO_SWITCH_ON,
    PowerState.SWITCHED_ON,
    PowerState.OPERATION_ENABLED,
)


@given(states, controlwords, controlwords)
def test_without_voltage_no_drive_that_is_sound_stays_switched_on(state, controlword, previous):
    after = next_state(state, controlword & ~0x02, previous)
    assert after is DISABLED or state in FAULTY


@given(controlwords, controlwords)
def test_only_an_edge_of_fault_reset_leaves_the_fault(controlword, previous):
    left = next_state(PowerState.FAULT, controlword, previous) is not PowerState.FAULT
    assert left == bool(controlword & ~previous & 0x80)


@given(states, controlwords, controlwords)
def test_operation_is_enabled_by_enable_operation_alone_and_never_from_disabled(state, controlword, previous):
    if next_state(state, controlword, previous) is ENABLED:
        assert controlword & 0x0F == 0x0F
        assert state is not DISABLED
        assert state not in FAULTY


@given(states, st.booleans(), st.booleans(), st.booleans())
def test_the_statusword_shows_the_state_and_the_bits(state, remote, reached, standing):
    word = statusword(state, remote=remote, target_reached=reached, standing=standing)
    shown = {mask: word & mask for mask in (0x4F, 0x6F)}
    free = state in {PowerState.SWITCH_ON_DISABLED, *FAULTY}  # the quick stop bit may have any value
    assert (shown[0x4F] == state & 0x4F) if free else (shown[0x6F] == state)
    assert (bool(word & 0x200), bool(word & 0x400), bool(word & 0x1000)) == (remote, reached, standing)


@pytest.mark.parametrize("state", [ENABLED, PowerState.QUICK_STOP_ACTIVE])
def test_quick_stop_stops_a_drive_that_runs(state):
    assert next_state(state, 0x02, 0) is PowerState.QUICK_STOP_ACTIVE
