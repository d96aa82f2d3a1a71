"""Sets the heartbeat of a node by SDO."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.driver.errors import NotTaken, SdoRefused

if TYPE_CHECKING:
    from omnimate.driver.canopen.notes import Notes
    from omnimate.driver.canopen.sdo import Sdo

HEARTBEAT_MS = 500
DRIVE_HEARTBEAT_MS = 25  # of a drive, whose loss must stop the robot within 100 ms
SHORTEST_MS, LONGEST_MS = 10, 2000


def set_heartbeat(
    sdo: Sdo, notes: Notes, wanted: int = HEARTBEAT_MS, longest: int = LONGEST_MS
) -> float | None:
    """Have the node produce a heartbeat (1017h); return its period [s], None where it has none.

    A heartbeat between `SHORTEST_MS` and `longest` is left as it is, and so is a node that refuses, with a
    remark.

    Args:
        sdo: Objects of the node.
        notes: Notes to add to.
        wanted: Period that is set [ms].
        longest: Longest period that is left as it is [ms].

    Raises:
        SdoSilent: The node stops answering.
    """
    period = sdo.find(0x1017)
    if period is None:
        notes.remarks.append("no heartbeat (1017h); its silence shows in its PDOs alone")
        return None
    if SHORTEST_MS <= period <= longest:
        notes.read.append(f"heartbeat 1017h = {period} ms")
        return period / 1000.0
    try:
        sdo.put(0x1017, 0, wanted)
    except (SdoRefused, NotTaken) as error:
        notes.remarks.append(f"heartbeat stays at {period} ms: {error.problem}")
        return period / 1000.0 or None
    notes.changed.append(f"heartbeat 1017h: {period} ms to {wanted} ms")
    return wanted / 1000.0
