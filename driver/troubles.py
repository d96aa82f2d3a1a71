"""What the frames of a node show that the driver must react to."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Trouble:
    """A node, or the bus, that is not as it must be.

    Attributes:
        time: When it was seen, on the recording's clock [s].
        node: CANopen node id; None where it concerns the bus.
        what: What was seen, in words.
        has_restarted: Whether the node may have lost its configuration.
        emergency: Error code of the EMCY frame that told it; None where it was another one.
        status: Status word 6041h with which a drive left operation enabled; None where it was another one.
    """

    time: float
    node: int | None
    what: str
    has_restarted: bool = False
    emergency: int | None = None
    status: int | None = None
