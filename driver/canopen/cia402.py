"""A CiA 402 drive: its state machine (control word 6040h, status word 6041h) and the RPDO of its target."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from omnimate.driver.canopen.pdo_mapping import Entry, length, placed
from omnimate.driver.errors import DriveError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from omnimate.driver.canopen.sdo import Sdo
    from omnimate.vehicle.parameters import Drive

PROFILE_VELOCITY = 3  # modes of operation 6060h
# Control words 6040h, and status words 6041h under their masks (CiA 402-2).
SHUTDOWN, SWITCH_ON, ENABLE_OPERATION, FAULT_RESET = 0x06, 0x07, 0x0F, 0x80
QUICK_STOP, DISABLE_VOLTAGE = 0x02, 0x00
FAULT_MASK, FAULT, FAULT_REACTION = 0x4F, 0x08, 0x0F
STATE_MASK = 0x6F
READY, SWITCHED_ON, ENABLED, QUICK_STOP_ACTIVE = 0x21, 0x23, 0x27, 0x07
POLLS, POLL_PAUSE = 200, 0.01  # times, [s]: two seconds in all, in which a brake opens

_STEPS = (
    (SHUTDOWN, READY, "ready to switch on"),
    (SWITCH_ON, SWITCHED_ON, "switched on"),
    (ENABLE_OPERATION, ENABLED, "operation enabled"),
)
TARGET_VELOCITY = Entry(0x60FF, 0, 32)
CONTROL_WORD = Entry(0x6040, 0, 16)
MODE = Entry(0x6060, 0, 8)
DUMMIES = range(0x0001, 0x0008)  # data types that fill a gap (CiA 301)
FILLER = Entry(0x0005, 0, 8)


def enable_drive(sdo: Sdo, pump: Callable[[float], None]) -> None:
    """Bring a drive to operation enabled in profile velocity mode at speed zero.

    A fault is reset, once the drive's reaction to it is over. A drive that stays in quick stop active (605Ah
    from 5 on) does not take shutdown there: its voltage is disabled first (CiA 402-2, transition 12). Raises
    SdoRefused, SdoSilent or NotTaken, and DriveError for a state that it does not reach.
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
    """Take the torque away; raises SdoRefused or SdoSilent."""
    sdo.write(0x6040, 0, SHUTDOWN)


def _await(sdo: Sdo, pump: Callable[[float], None], reached: Callable[[int], bool], expected: str) -> int:
    status = 0
    for _ in range(POLLS):
        status = sdo.read(0x6041)
        if reached(status):
            return status
        pump(POLL_PAUSE)
    raise DriveError(sdo.node, status, expected)


@dataclass(frozen=True, slots=True)
class TargetPdo:
    """The RPDO of one drive."""

    cob_id: int  # its COB-ID
    # objects that it carries, in order: the target velocity, control word, mode and fillers
    entries: tuple[Entry, ...]

    @property
    def start_bit(self) -> int:
        """First bit of the target velocity."""
        return next(bit for bit, entry in placed(self.entries) if entry == TARGET_VELOCITY)

    def data(self, target: int, control: int) -> bytes:
        """Return the bytes for a target velocity 60FFh [counts/s] and a control word 6040h."""
        values = {TARGET_VELOCITY: target, CONTROL_WORD: control, MODE: PROFILE_VELOCITY}
        fields = ((values.get(entry, 0) % (1 << entry.bits)) << bit for bit, entry in placed(self.entries))
        return sum(fields).to_bytes(length(self.entries), "little")


def planned_pdo(drive: Drive) -> TargetPdo:
    """Return the RPDO as `vehicle.toml` describes it: before the velocity, the control word where it fits."""
    gap = drive.start_bit
    entries: list[Entry] = []
    if gap >= CONTROL_WORD.bits:
        entries.append(CONTROL_WORD)
        gap -= CONTROL_WORD.bits
    return TargetPdo(drive.cob_id, (*entries, *[FILLER] * (gap // FILLER.bits), TARGET_VELOCITY))


def takes_target(entries: Sequence[Entry]) -> bool:
    """Return whether a mapping takes the target velocity once, and else only what the driver can send."""
    others = [entry for entry in entries if entry != TARGET_VELOCITY]
    return len(others) == len(entries) - 1 and all(
        entry in {CONTROL_WORD, MODE} or entry.index in DUMMIES for entry in others
    )
