"""What `triage` answers: one object, written as JSON."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from omnimate.mismatch.diagnosis import Alternative, Where

if TYPE_CHECKING:
    from omnimate.mismatch.diagnosis import Verdict


@dataclass(frozen=True, slots=True)
class Triage:
    """The answer to recordings of one robot.

    Attributes:
        verdict: agreement, mismatch or insufficient.
        says: It in a sentence; for "insufficient", what to record.
        robot: Name of the vehicle.
        recordings: Names, in order.
        probability: That anything at all is there; from 0.5 on the verdict is a mismatch.
        where: The signals on which it shows, and the blocks of time that hold half of it; no interval where
            it acts all along the drive.
        closest: Effects that come closest to it, each as if nothing else were there, likeliest first.
        heldout: How far the best of them helps where its fit has not seen the data: gain in log density.
    """

    verdict: Verdict
    says: str
    robot: str
    recordings: tuple[str, ...]
    probability: float = 0.0
    where: Where = field(default_factory=Where)
    closest: tuple[Alternative, ...] = ()
    heldout: float = 0.0

    def as_json(self) -> dict[str, Any]:
        """Return the object that is written."""
        return {
            "verdict": self.verdict,
            "says": self.says,
            "robot": self.robot,
            "recordings": list(self.recordings),
            "probability": self.probability,
            "where": self.where.as_json(),
            "closest": [one.as_json() for one in self.closest],
            "heldout": self.heldout,
        }
