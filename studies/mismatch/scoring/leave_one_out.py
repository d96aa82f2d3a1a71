"""Leave one out: an effect that is missing from a tool's library must not get the name of another effect."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from studies.mismatch.scoring.judging import ASSERTED, UNNAMED, Answer, Label, asserted, wrong

Outcome = Literal["unknown", "acceptable", "wrong name", "nothing"]
OUTCOMES: tuple[Outcome, ...] = ("unknown", "acceptable", "wrong name", "nothing")


@dataclass(frozen=True, slots=True)
class LeftOut:
    """One line of the table."""

    effect: str  # effect that was left out of the library
    outcomes: Mapping[Outcome, int]  # number of cases with each outcome

    @property
    def cases(self) -> int:
        """Number of recordings that conceal the effect."""
        return sum(self.outcomes.values())


def concealing(labels: Mapping[str, Label]) -> dict[str, str]:
    """Return the effect of every case that conceals one named effect and nothing else."""
    return {name: label["effects"][0]["effect"] for name, label in labels.items() if _conceals_one(label)}


def _conceals_one(label: Label) -> bool:
    return label["kind"] in {"single", "masked"} and len(label["effects"]) == 1


def outcome(label: Label, answer: Answer) -> Outcome:
    """Return the outcome of an answer about a missing effect; a wrong name among its assertions decides."""
    assertions = asserted(answer, ASSERTED)
    named = [finding for finding in assertions if finding["effect"] not in UNNAMED]
    if any(wrong(finding, label) for finding in named):
        return "wrong name"
    if len(named) < len(assertions):
        return "unknown"
    return "acceptable" if named else "nothing"


def left_out_rows(labels: Mapping[str, Label], answers: Mapping[str, Answer]) -> list[LeftOut]:
    """Return a line for every effect, and one for all of them."""
    outcomes: dict[str, Counter[Outcome]] = {}
    for name, effect in concealing(labels).items():
        if name in answers:
            outcomes.setdefault(effect, Counter())[outcome(labels[name], answers[name])] += 1
    whole: Counter[Outcome] = sum(outcomes.values(), Counter())
    return [*(LeftOut(*pair) for pair in sorted(outcomes.items())), LeftOut("all", whole)]
