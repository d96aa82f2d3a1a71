"""Judging one answer by its label: what is asserted, what is right, and what is in the set. JSON in."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Any, Literal

import numpy as np

SURE = 0.9  # probability from which an answer is sure
ASSERTED = 0.5  # probability from which a finding is an assertion
SET = 0.95  # probability of a credible set
UNNAMED = ("unknown", "law")  # names of what the vocabulary has no word for

Label = dict[str, Any]
Answer = dict[str, Any]


def asserted(answer: Answer, least: float) -> list[dict[str, Any]]:
    """Return the findings of at least a probability."""
    return [finding for finding in answer["findings"] if finding["probability"] >= least]


def names_of(parts: Iterable[Mapping[str, Any]]) -> set[tuple[str, str]]:
    """Return effect and component of each finding, or of each effect of a label."""
    return {(part["effect"], part["component"]) for part in parts}


def fits(effect: str, component: str, truth: Label) -> bool:
    """Say whether an effect on a component is the truth, or one that the drive cannot separate from it."""
    if truth["effect"] == "unknown" and effect in UNNAMED:
        return True
    return (effect, component) in names_of([truth, *truth.get("acceptable", ())])


def wrong(finding: dict[str, Any], label: Label) -> bool:
    """Say whether a finding is neither one of the label's effects nor one that looks like them."""
    if is_secondary(finding, label):
        return False
    return not any(fits(finding["effect"], finding["component"], truth) for truth in label["effects"])


def is_secondary(finding: dict[str, Any], label: Label) -> bool:
    """Say whether a finding is true but no effect of the label: naming it is right, missing it no mistake."""
    secondary = (*label.get("secondary", ()), *label.get("acceptable_findings", ()))
    return names_of([finding]) <= names_of(secondary)


def first_right(label: Label, answer: Answer) -> bool:
    """Say whether the first findings are the label's effects, as far as the drive can separate them."""
    first = answer["findings"][: max(1, len(label["effects"]))]
    return bool(first) and not any(wrong(finding, label) for finding in first)


def first_exact(label: Label, answer: Answer) -> bool:
    """Say whether the first findings are the label's effects by name and component."""
    truth = names_of(label["effects"])
    return names_of(answer["findings"][: len(truth)]) == truth


def reported_instead(labels: Mapping[str, Label], answers: Mapping[str, Answer]) -> Counter[tuple[str, str]]:
    """Return how often another name counted as right for a single effect, by (truth, reported)."""
    counts: Counter[tuple[str, str]] = Counter()
    for name, label in labels.items():
        answer = answers.get(name)
        if label["kind"] != "single" or answer is None or first_exact(label, answer):
            continue
        if first_right(label, answer):
            truth, first = label["effects"][0], answer["findings"][0]
            counts[f"{truth['effect']} {truth['component']}", f"{first['effect']} {first['component']}"] += 1
    return counts


def all_right(label: Label, answer: Answer) -> bool:
    """Say whether the assertions are the label's effects, one each, and nothing else."""
    likely = asserted(answer, ASSERTED / 2)
    matched = [
        sum(fits(finding["effect"], finding["component"], truth) for finding in likely)
        for truth in label["effects"]
    ]
    beside = sum(
        is_secondary(finding, label)
        and not any(fits(finding["effect"], finding["component"], truth) for truth in label["effects"])
        for finding in likely
    )
    return len(likely) - beside == len(label["effects"]) and all(matched)


def credible(finding: dict[str, Any]) -> list[tuple[str, str]]:
    """Return the fewest names that together have 95 % of the probability."""
    names = [(finding["probability"], finding["effect"], finding["component"])]
    names += [
        (other["probability"], other["effect"], other["component"]) for other in finding["alternatives"]
    ]
    likeliest, total = [], 0.0
    for probability, effect, component in sorted(names, reverse=True):
        likeliest.append((effect, component))
        total += probability
        if total >= SET:
            break
    return likeliest


def in_set(truth: Label, answer: Answer) -> bool:
    """Say whether an effect is in the 95 % set of any finding."""
    return any(fits(*name, truth) for finding in answer["findings"] for name in credible(finding))


def is_found(label: Label, answer: Answer) -> bool:
    """Say whether each effect is in the set of a finding that, with its alternatives, is an assertion."""
    likely = [finding for finding in answer["findings"] if _total(finding) >= ASSERTED]
    return all(
        any(fits(*name, truth) for finding in likely for name in credible(finding))
        for truth in label["effects"]
    )


def _total(finding: dict[str, Any]) -> float:
    alternatives = sum(other["probability"] for other in finding["alternatives"])
    return float(finding["probability"] + alternatives)


def beyond_twins(labels: Mapping[str, Label], answers: Mapping[str, Answer]) -> dict[str, Answer]:
    """Return answers without the findings that the untouched twin has as well, the truth excepted.

    A real recording may hold physics of its own; what an injection is judged by is what came with it.
    """
    return {
        name: _beyond(answer, labels[name], answers.get(labels[name].get("twin", "")))
        for name, answer in answers.items()
        if name in labels
    }


def _beyond(answer: Answer, label: Label, twin: Answer | None) -> Answer:
    if twin is None:
        return answer
    known = names_of(asserted(twin, ASSERTED)) - names_of(label["effects"])
    kept = [finding for finding in answer["findings"] if not names_of([finding]) & known]
    return {**answer, "findings": kept}


def says_unknown(label: Label, answer: Answer) -> bool:
    """Say whether the first assertion is that something unknown acts."""
    first = asserted(answer, ASSERTED)[:1]
    return any(finding["effect"] in UNNAMED for finding in first) and bool(label["effects"])


def events(pairs: Iterable[tuple[Label, Answer]]) -> tuple[list[bool], list[bool]]:
    """Return whether the onset, and the extent, of every true event of a named effect were found."""
    onset, overlap = [], []
    for truth, finding, period in _matches(pairs):
        for start, end in truth["intervals"] if truth["effect"] in {"bump", "slip_patch"} else ():
            intervals = finding["where"]["intervals"]
            near = min(intervals, key=lambda interval: abs(interval[0] - start), default=None)
            if near is None:
                onset.append(False)
                continue
            onset.append(abs(near[0] - start) <= 2.5 * period)
            shared = max(0.0, min(near[1], end) - max(near[0], start))
            whole = max(near[1], end) - min(near[0], start)
            if truth["effect"] == "slip_patch":
                overlap.append(shared / whole >= 0.8)
    return onset, overlap


def deviations(pairs: Iterable[tuple[Label, Answer]]) -> list[float]:
    """Return the error of every estimated parameter in its sigmas."""
    errors = []
    for truth, finding, _ in _matches(pairs):
        for name, parameter in truth["parameters"].items():
            estimate = finding["parameters"].get(name)
            if (
                estimate is None
                or isinstance(parameter["value"], list)
                or name in {"phase", "order", "above", "time", "direction"}
            ):
                continue
            value, sigma = float(np.mean(estimate["value"])), float(np.mean(estimate["sigma"]))
            if sigma > 0.0:
                errors.append((value - parameter["value"]) / sigma)
    return errors


def _matches(pairs: Iterable[tuple[Label, Answer]]) -> Iterable[tuple[Label, dict[str, Any], float]]:
    """Yield every true effect, the finding of the same name, and the sample period [s]."""
    for label, answer in pairs:
        for truth in label["effects"]:
            for finding in answer["findings"]:
                if names_of([finding]) == names_of([truth]):
                    yield truth, finding, label.get("period", 0.02)


Outcome = Literal["unknown", "acceptable", "wrong name", "nothing"]
OUTCOMES: tuple[Outcome, ...] = ("unknown", "acceptable", "wrong name", "nothing")


def concealing(labels: Mapping[str, Label]) -> dict[str, str]:
    """Return the effect of every case that conceals one named effect and nothing else."""
    return {
        name: label["effects"][0]["effect"]
        for name, label in labels.items()
        if label["kind"] in {"single", "masked"} and len(label["effects"]) == 1
    }


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
