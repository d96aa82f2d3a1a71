"""The result of `triage`, which is written as JSON."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from omnimate.mismatch.diagnosis import Alternative, Where, as_plain

if TYPE_CHECKING:
    from omnimate.mismatch.diagnosis import Verdict


@dataclass(frozen=True, slots=True)
class Triage:
    """Triage of recordings of one robot.

    Attributes:
        verdict: agreement, mismatch or insufficient.
        says: The verdict in a sentence; for "insufficient", what to record.
        robot: Name of the vehicle.
        recordings: Names of the recordings, in order.
        probability: Probability of any mismatch; from 0.5 on the verdict is a mismatch.
        where: The signals on which it shows, and the blocks of time that hold half of it; no interval where
            it acts all along the drive.
        closest: Effects that explain it best, each considered alone, most probable first.
        heldout: Gain in log density of held-out data by the best of them [nat].
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
        """Return the JSON object."""
        answer: dict[str, Any] = as_plain(self)
        return answer
