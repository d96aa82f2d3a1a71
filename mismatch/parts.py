"""The parts of the method, each of which can be left out to measure what it is worth."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Parts:
    """Which parts of the method are at work.

    Attributes:
        unknown: what no effect explains competes with the library, as a bank of plain curves.
        waves: the floor's roughness is alike along a length of its own; else it is white.
        foreseen: effects act on the readings that odometry foresees; else on the readings themselves.
        refinement: the best set and its rivals are fitted by Gauss-Newton; else all stay straight lines.
    """

    unknown: bool = True
    waves: bool = True
    foreseen: bool = True
    refinement: bool = True


WHOLE = Parts()
ABLATIONS = {
    "without the unknown": Parts(unknown=False),
    "floor without waves": Parts(waves=False),
    "readings not foreseen": Parts(foreseen=False),
    "without refinement": Parts(refinement=False),
}
