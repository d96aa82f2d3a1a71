"""Leave one out: an effect that is missing from a tool's library must not get the name of another effect."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import Literal

from studies.mismatch.scoring.judging import ASSERTED, UNNAMED, Answer, Label, asserted, wrong

Outcome = Literal["unknown", "acceptable", "wrong name", "nothing"]
OUTCOMES: tuple[Outcome, ...] = ("unknown", "acceptable", "wrong name", "nothing")


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


def left_out_rows(labels: Mapping[str, Label], answers: Mapping[str, Answer]) -> dict[str, Counter[Outcome]]:
    """Return how many cases of every effect that is left out have each outcome, and of all of them."""
    outcomes: dict[str, Counter[Outcome]] = {}
    for name, effect in concealing(labels).items():
        if name in answers:
            outcomes.setdefault(effect, Counter())[outcome(labels[name], answers[name])] += 1
    return {**dict(sorted(outcomes.items())), "all": sum(outcomes.values(), Counter())}
