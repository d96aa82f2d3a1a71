"""The score of each world, and of the worlds that others made together."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from studies.mismatch.scoring.reliability import bins
from studies.mismatch.scoring.score import rows

if TYPE_CHECKING:
    from collections.abc import Sequence

    from studies.mismatch.asking import Answers
    from studies.mismatch.scoring.reliability import Bin
    from studies.mismatch.scoring.score import Line
    from studies.mismatch.worlds.world import Corpus


@dataclass(frozen=True, slots=True)
class Score:
    """What a tool's answers about a world are worth.

    Attributes:
        name: Name of the world.
        title: What tables call it.
        cases: Number of cases.
        digest: SHA-256 of the labels; empty where worlds are pooled.
        lines: The lines of the table, the same in every world.
        reliability: What was said against what is right.
    """

    name: str
    title: str
    cases: int
    digest: str
    lines: Sequence[Line]
    reliability: Sequence[Bin]

    def as_json(self) -> dict[str, Any]:
        """Return the score as an object."""
        return {
            "title": self.title,
            "cases": self.cases,
            "labels": self.digest,
            "lines": [line.as_json() for line in self.lines],
            "reliability": [each.as_json() for each in self.reliability],
        }


def scored(corpus: Corpus, answers: Answers) -> Score:
    """Return the score of one world."""
    labels = corpus.labels
    return Score(
        corpus.world.name,
        corpus.world.title,
        len(labels),
        corpus.digest,
        rows(labels, answers),
        bins(labels, answers),
    )


def pooled(asked: Sequence[tuple[Corpus, Answers]]) -> list[Score]:
    """Return the score of all worlds that others made, as one; nothing where they are fewer than two."""
    foreign = [(corpus, answers) for corpus, answers in asked if corpus.world.foreign]
    if len(foreign) < 2:
        return []
    labels = {
        f"{corpus.world.name} {case}": corpus.labels[case] for corpus, _ in foreign for case in corpus.labels
    }
    answered = {
        f"{corpus.world.name} {case}": answers[case] for corpus, answers in foreign for case in answers
    }
    return [
        Score("foreign", "foreign, pooled", len(labels), "", rows(labels, answered), bins(labels, answered))
    ]
