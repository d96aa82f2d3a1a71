"""Sets the heartbeat of a node by SDO."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.driver.errors import NotTaken, SdoRefused

if TYPE_CHECKING:
    from omnimate.driver.notes import Notes
    from omnimate.driver.sdo import Sdo

HEARTBEAT_MS = 500
HEARTBEAT_BOUNDS_MS = (100, 2000)  # a heartbeat within them is left as it is


def set_heartbeat(sdo: Sdo, notes: Notes) -> float | None:
    """Have the node produce a heartbeat (1017h); return its period [s], None where it has none.

    A node that refuses is left as it is, with a remark.

    Raises:
        SdoSilent: The node stops answering.
    """
    period = sdo.find(0x1017)
    if period is None:
        notes.remarks.append("no heartbeat (1017h); its silence shows in its PDOs alone")
        return None
    least, most = HEARTBEAT_BOUNDS_MS
    if least <= period <= most:
        notes.read.append(f"heartbeat 1017h = {period} ms")
        return period / 1000.0
    try:
        sdo.put(0x1017, 0, HEARTBEAT_MS)
    except (SdoRefused, NotTaken) as error:
        notes.remarks.append(f"heartbeat stays at {period} ms: {error.problem}")
        return period / 1000.0 or None
    notes.changed.append(f"heartbeat 1017h: {period} ms to {HEARTBEAT_MS} ms")
    return HEARTBEAT_MS / 1000.0
