"""The RPDO by which a CiA 402 drive gets its target velocity, and its control word where it maps both."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from omnimate.driver.canopen.drive_states import PROFILE_VELOCITY
from omnimate.driver.canopen.pdo_mapping import Entry, length

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.vehicle.parameters import Drive

TARGET_VELOCITY = Entry(0x60FF, 0, 32)
CONTROL_WORD = Entry(0x6040, 0, 16)
MODE = Entry(0x6060, 0, 8)
DUMMIES = range(0x0001, 0x0008)  # data types that fill a gap (CiA 301)
FILLER = Entry(0x0005, 0, 8)


@dataclass(frozen=True, slots=True)
class TargetPdo:
    """The RPDO of one drive.

    Attributes:
        cob_id: Its COB-ID.
        entries: Objects that it carries, in order: the target velocity, and what the driver knows besides.
    """

    cob_id: int
    entries: tuple[Entry, ...]

    @property
    def start_bit(self) -> int:
        """First bit of the target velocity."""
        before = self.entries[: self.entries.index(TARGET_VELOCITY)]
        return sum(entry.bits for entry in before)

    def data(self, target: int, control: int) -> bytes:
        """Return the bytes for a target velocity 60FFh [counts/s] and a control word 6040h."""
        values = {TARGET_VELOCITY: target, CONTROL_WORD: control, MODE: PROFILE_VELOCITY}
        word = bit = 0
        for entry in self.entries:
            word |= (values.get(entry, 0) % (1 << entry.bits)) << bit
            bit += entry.bits
        return word.to_bytes(length(self.entries), "little")


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
