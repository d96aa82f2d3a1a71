"""The power drive state machine of CiA 402: states, controlword and statusword (CiA 402-2 figure 9)."""

from __future__ import annotations

from enum import IntEnum

_SHUTDOWN, _SWITCH_ON, _ENABLE = 0x06, 0x07, 0x0F
_VOLTAGE, _NO_QUICK_STOP, _FAULT_RESET = 0x02, 0x04, 0x80


class PowerState(IntEnum):
    """The states, by the bits of the statusword (mask 6Fh) that show them."""

    SWITCH_ON_DISABLED = 0x40
    READY_TO_SWITCH_ON = 0x21
    SWITCHED_ON = 0x23
    OPERATION_ENABLED = 0x27
    QUICK_STOP_ACTIVE = 0x07
    FAULT_REACTION_ACTIVE = 0x0F
    FAULT = 0x08


_FAULTY = {PowerState.FAULT, PowerState.FAULT_REACTION_ACTIVE}
_POWERED = {PowerState.SWITCHED_ON, PowerState.OPERATION_ENABLED}


def next_state(state: PowerState, controlword: int, previous: int) -> PowerState:
    """Return the state after a controlword; `previous` is the one before, for the edge of fault reset."""
    if state in _FAULTY:
        edge = controlword & ~previous & _FAULT_RESET
        return PowerState.SWITCH_ON_DISABLED if edge and state is PowerState.FAULT else state
    if not controlword & _VOLTAGE:
        return PowerState.SWITCH_ON_DISABLED
    if not controlword & _NO_QUICK_STOP:
        enabled = state in {PowerState.OPERATION_ENABLED, PowerState.QUICK_STOP_ACTIVE}
        return PowerState.QUICK_STOP_ACTIVE if enabled else PowerState.SWITCH_ON_DISABLED
    return _towards_enabled(state, controlword & _ENABLE)


def _towards_enabled(state: PowerState, command: int) -> PowerState:
    """Return the state after shutdown, switch on or enable operation; the first must be shutdown."""
    if command & _SWITCH_ON == _SHUTDOWN:
        return PowerState.READY_TO_SWITCH_ON
    if state is PowerState.SWITCH_ON_DISABLED:
        return state
    if state is PowerState.QUICK_STOP_ACTIVE:
        return PowerState.OPERATION_ENABLED if command == _ENABLE else state
    return PowerState.OPERATION_ENABLED if command == _ENABLE else PowerState.SWITCHED_ON


def statusword(state: PowerState, *, remote: bool, target_reached: bool, standing: bool) -> int:
    """Return 6041h: the state, voltage enabled, remote, target reached, and speed is zero."""
    word = int(state)
    if state not in _FAULTY and state is not PowerState.QUICK_STOP_ACTIVE:
        word |= 0x20  # the quick stop bit is inverted; its value in the other states is free
    if state in _POWERED:
        word |= 0x10
    return word | remote << 9 | target_reached << 10 | standing << 12
