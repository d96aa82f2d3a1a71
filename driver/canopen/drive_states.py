"""The state machine of one CiA 402 drive, by control word 6040h and status word 6041h."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.driver.errors import DriveError

if TYPE_CHECKING:
    from collections.abc import Callable

    from omnimate.driver.canopen.sdo import Sdo

PROFILE_VELOCITY = 3
SHUTDOWN, SWITCH_ON, ENABLE_OPERATION, FAULT_RESET = 0x06, 0x07, 0x0F, 0x80
QUICK_STOP, DISABLE_VOLTAGE = 0x02, 0x00
FAULT_MASK, FAULT, FAULT_REACTION = 0x4F, 0x08, 0x0F
STATE_MASK = 0x6F
READY, SWITCHED_ON, ENABLED, QUICK_STOP_ACTIVE = 0x21, 0x23, 0x27, 0x07
POLLS, POLL_PAUSE = 200, 0.01  # [s]: a brake may take two seconds to open

_STEPS = (
    (SHUTDOWN, READY, "ready to switch on"),
    (SWITCH_ON, SWITCHED_ON, "switched on"),
    (ENABLE_OPERATION, ENABLED, "operation enabled"),
)


def enable_drive(sdo: Sdo, pump: Callable[[float], None]) -> None:
    """Bring a drive to operation enabled in profile velocity mode at speed zero.

    A fault is reset, once the drive's reaction to it is over. A drive that stays in quick stop active (605Ah
    from 5 on) does not take shutdown there: its voltage is disabled first (CiA 402-2, transition 12).

    Args:
        sdo: Objects of the drive's node.
        pump: Reads and handles one frame, waiting for it at most so many seconds.

    Raises:
        DriveError: The drive does not reach a state.
        NotTaken: The drive confirmed a value and kept another one.
        SdoRefused: The drive aborts a transfer.
        SdoSilent: The drive stops answering.
    """
    what = "the end of its fault reaction"
    status = _await(sdo, pump, lambda status: status & FAULT_MASK != FAULT_REACTION, what)
    if status & FAULT_MASK == FAULT:
        sdo.write(0x6040, 0, FAULT_RESET)
        _await(sdo, pump, lambda status: status & FAULT_MASK != FAULT, "no fault after a reset")
    elif status & STATE_MASK == QUICK_STOP_ACTIVE:
        sdo.write(0x6040, 0, DISABLE_VOLTAGE)
        _await(
            sdo, pump, lambda status: status & STATE_MASK != QUICK_STOP_ACTIVE, "the end of its quick stop"
        )
    sdo.write(0x60FF, 0, 0)  # even where it reads zero
    sdo.put(0x60FF, 0, 0)
    sdo.write(0x6060, 0, PROFILE_VELOCITY)
    for control, state, name in _STEPS:
        sdo.write(0x6040, 0, control)
        _await(sdo, pump, lambda status, state=state: status & STATE_MASK == state, name)  # type: ignore[misc]  # bound
    mode = sdo.find(0x6061)
    if mode is not None and mode != PROFILE_VELOCITY:
        raise DriveError(sdo.node, sdo.read(0x6041), f"profile velocity mode (3), but 6061h shows {mode}")


def disable_drive(sdo: Sdo) -> None:
    """Take the torque away.

    Raises:
        SdoRefused: The drive aborts the transfer.
        SdoSilent: The drive stops answering.
    """
    sdo.write(0x6040, 0, SHUTDOWN)


def _await(sdo: Sdo, pump: Callable[[float], None], reached: Callable[[int], bool], expected: str) -> int:
    status = 0
    for _ in range(POLLS):
        status = sdo.read(0x6041)
        if reached(status):
            return status
        pump(POLL_PAUSE)
    raise DriveError(sdo.node, status, expected)
