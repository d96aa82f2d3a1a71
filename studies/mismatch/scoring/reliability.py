"""Reliability: of the findings that were given a probability, how many are right."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from studies.mismatch.scoring.intervals import wilson
from studies.mismatch.scoring.judging import beyond_twins, wrong

if TYPE_CHECKING:
    from collections.abc import Mapping

    from studies.mismatch.scoring.judging import Answer, Label

# Bounds of the bins: finer where answers are sure, because that is where a false one does harm.
EDGES = (0.0, 0.1, 0.25, 0.5, 0.75, 0.9, 0.99, 1.0)


@dataclass(frozen=True, slots=True)
class Bin:
    """Findings of about the same probability.

    Attributes:
        said: Mean of their probabilities.
        right: Number of those that are right.
        of: Number of all.
    """

    said: float
    right: int
    of: int

    @property
    def share(self) -> float:
        """Share of those that are right."""
        return self.right / self.of

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson's 95 % interval of the share."""
        return wilson(self.right, self.of)

    def as_json(self) -> dict[str, Any]:
        """Return the bin as an object."""
        return {"said": self.said, "right": self.right, "of": self.of, "interval": list(self.interval)}


def bins(labels: Mapping[str, Label], answers: Mapping[str, Answer]) -> list[Bin]:
    """Return the findings about a world in bins of their probability, those that are empty left out."""
    answers = beyond_twins(labels, answers)
    said = [
        (finding["probability"], not wrong(finding, label))
        for name, label in labels.items()
        for finding in answers.get(name, {"findings": ()})["findings"]
    ]
    filled = []
    for low, high in pairwise(EDGES):
        inside = [
            pair for pair in said if low <= pair[0] < high or (high == EDGES[-1] and pair[0] >= EDGES[-1])
        ]
        if inside:
            mean = sum(probability for probability, _ in inside) / len(inside)
            filled.append(Bin(mean, sum(right for _, right in inside), len(inside)))
    return filled
