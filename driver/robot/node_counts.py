"""Frame counters of the nodes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from omnimate.vehicle.parameters import VehicleParameters


@dataclass(slots=True)
class NodeCounts:
    """How many frames of one node were received, and what was wrong with them.

    Attributes:
        received: PDOs that entered a sample.
        missing: SYNCs that a PDO of the node did not answer in time.
        late: PDOs that came after their sample was closed.
        duplicate: Second answers to one SYNC.
        wrong_length: PDOs, heartbeats or EMCYs of an impossible length.
        unknown: Frames of this node that nothing expects.
        jumps: Readings that no robot can make.
    """

    received: int = 0
    missing: int = 0
    late: int = 0
    duplicate: int = 0
    wrong_length: int = 0
    unknown: int = 0
    jumps: int = 0


def nodes_of(vehicle: VehicleParameters) -> tuple[int, ...]:
    """Return the node ids of a vehicle's encoders and drives, in order."""
    encoders = {encoder.node for encoder in vehicle.encoders}
    return tuple(sorted(encoders | {drive.node for drive in vehicle.drives}))
