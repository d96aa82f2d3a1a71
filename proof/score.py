"""The score: what a tool's answers are worth against labels that it has not seen. JSON in, rows out."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

SURE = 0.9
ASSERTED = 0.5
SET = 0.95


@dataclass(frozen=True, slots=True)
class Row:
    """One line of the table.

    Attributes:
        name: of what was counted.
        hits: how often it was so.
        of: how often it could have been.
        target: share that is wanted; at most that where `most`.
        most: whether the target is an upper bound.
        note: in words.
    """

    name: str
    hits: int
    of: int
    target: float | None = None
    most: bool = False
    note: str = ""

    @property
    def share(self) -> float:
        """Hits over all; nan where nothing could have been."""
        return self.hits / self.of if self.of else math.nan

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson's 95 % interval of the share."""
        if not self.of:
            return math.nan, math.nan
        z, n, p = 1.96, self.of, self.share
        middle, width = p + z * z / (2 * n), z * math.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
        return (middle - width) / (1 + z * z / n), (middle + width) / (1 + z * z / n)

    @property
    def verdict(self) -> str:
        """Whether the target is reached."""
        if self.target is None or not self.of:
            return ""
        reached = self.share <= self.target if self.most else self.share >= self.target
        return "reached" if reached else "NOT REACHED"


Label = dict[str, Any]
Answer = dict[str, Any]


def rows(labels: Mapping[str, Label], answers: Mapping[str, Answer], ease: float = 1.0) -> list[Row]:
    """Return the table of a corpus.

    Args:
        labels: of each case, as `labels.json` holds them.
        answers: of each case, as `Diagnosis.as_json` gives them.
        ease: factor on the targets; what is to be at most a target may be as much larger.
    """
    return [
        row
        if row.target is None
        else replace(row, target=row.target / ease if row.most else row.target * ease)
        for row in _rows(labels, answers)
    ]


def _rows(labels: Mapping[str, Label], answers: Mapping[str, Answer]) -> list[Row]:
    pairs = [(label, answers[name]) for name, label in labels.items() if name in answers]
    nulls = [answer for label, answer in pairs if label["kind"] == "null"]
    known = [(label, answer) for label, answer in pairs if label["kind"] in {"single", "masked"}]
    multi = [
        (label, answer) for label, answer in pairs if len(label["effects"]) == 2 and label["kind"] == "multi"
    ]
    strange = [(label, answer) for label, answer in pairs if label["kind"] == "unknown"]
    sure = [wrong(finding, label) for label, answer in pairs for finding in asserted(answer, SURE)]
    every = [truth for label, _ in known + multi for truth in label["effects"]]
    sets = [in_set(truth, answer) for label, answer in known + multi for truth in label["effects"]]
    sizes = [len(credible(finding)) for _, answer in known + multi for finding in asserted(answer, ASSERTED)]
    after = [answer["fit"]["heldout"]["after"] for _, answer in known if answer["fit"]]
    onset, iou = events(known + multi)
    z = deviations(known + multi)
    return [
        Row(
            "false alarm on a null",
            sum(bool(asserted(answer, ASSERTED)) for answer in nulls),
            len(nulls),
            0.01,
            most=True,
        ),
        Row("sure (0.9) and wrong", sum(sure), len(sure), 0.01, most=True),
        Row("single: right first", sum(first_right(*pair) for pair in known), len(known), 0.97),
        Row("single: exactly the truth first", sum(first_exact(*pair) for pair in known), len(known)),
        Row("two at once: exactly right", sum(all_right(*pair) for pair in multi), len(multi), 0.9),
        Row("95 % set holds the truth", sum(sets), len(every), 0.95, note=f"mean size {_mean(sizes):.2f}"),
        Row("event onset within two samples", sum(onset), len(onset), 0.9),
        Row("interval overlap of 0.8", sum(iou), len(iou), 0.9),
        Row("parameter within 2 sigma", sum(abs(one) <= 2.0 for one in z), len(z), 0.95),
        Row("held-out residual after <= 1.05", sum(one <= 1.05 for one in after), len(after), 0.95),
        Row("unknown called unknown", sum(says_unknown(*pair) for pair in strange), len(strange), 0.9),
    ]


def asserted(answer: Answer, least: float) -> list[dict[str, Any]]:
    """Return the findings of at least a probability."""
    return [finding for finding in answer["findings"] if finding["probability"] >= least]


def fits(effect: str, component: str, truth: Label) -> bool:
    """Say whether an effect on a component is the truth, or what the drive cannot tell from it."""
    right = {(truth["effect"], truth["component"])}
    right |= {(one["effect"], one["component"]) for one in truth.get("acceptable", ())}
    if truth["effect"] == "unknown" and effect == "unknown":
        return True
    return (effect, component) in right


def wrong(finding: dict[str, Any], label: Label) -> bool:
    """Say whether a finding is none of the label's effects, nor one that looks like them."""
    extra = label.get("acceptable_findings", [])
    if any(finding["effect"] == one["effect"] and finding["component"] == one["component"] for one in extra):
        return False
    return not any(fits(finding["effect"], finding["component"], truth) for truth in label["effects"])


def first_right(label: Label, answer: Answer) -> bool:
    """Say whether the first findings are the label's effects, as far as the drive can tell."""
    first = answer["findings"][: max(1, len(label["effects"]))]
    return bool(first) and not any(wrong(finding, label) for finding in first)


def first_exact(label: Label, answer: Answer) -> bool:
    """Say whether the first findings are the label's effects by name and component."""
    truth = {(one["effect"], one["component"]) for one in label["effects"]}
    first = {(one["effect"], one["component"]) for one in answer["findings"][: len(truth)]}
    return first == truth


def told_instead(labels: Mapping[str, Label], answers: Mapping[str, Answer]) -> Counter[tuple[str, str]]:
    """Return how often, of single effects, what counts as right was another name: truth and told."""
    found: Counter[tuple[str, str]] = Counter()
    for name, label in labels.items():
        answer = answers.get(name)
        if label["kind"] != "single" or answer is None or first_exact(label, answer):
            continue
        if first_right(label, answer):
            truth, told = label["effects"][0], answer["findings"][0]
            found[f"{truth['effect']} {truth['component']}", f"{told['effect']} {told['component']}"] += 1
    return found


def all_right(label: Label, answer: Answer) -> bool:
    """Say whether the assertions are the label's effects, one each, and nothing else."""
    found = [one for one in answer["findings"] if one["probability"] >= ASSERTED / 2]
    matched = [
        sum(fits(one["effect"], one["component"], truth) for one in found) for truth in label["effects"]
    ]
    return len(found) == len(label["effects"]) and all(matched)


def credible(finding: dict[str, Any]) -> list[tuple[str, str]]:
    """Return the fewest names that together have 95 % of the probability."""
    names = [(finding["probability"], finding["effect"], finding["component"])]
    names += [(one["probability"], one["effect"], one["component"]) for one in finding["alternatives"]]
    found, total = [], 0.0
    for probability, effect, component in sorted(names, reverse=True):
        found.append((effect, component))
        total += probability
        if total >= SET:
            break
    return found


def in_set(truth: Label, answer: Answer) -> bool:
    """Say whether an effect is in the 95 % set of any finding."""
    return any(fits(*name, truth) for finding in answer["findings"] for name in credible(finding))


def says_unknown(label: Label, answer: Answer) -> bool:
    """Say whether something is called unknown, and nothing is asserted that is wrong."""
    found = asserted(answer, ASSERTED)
    return any(one["effect"] == "unknown" for one in found[:1]) and bool(label["effects"])


def events(pairs: Iterable[tuple[Label, Answer]]) -> tuple[list[bool], list[bool]]:
    """Return for every true event of a named effect whether its onset, and its extent, were found."""
    onset, overlap = [], []
    for truth, finding, period in _matches(pairs):
        for start, end in truth["intervals"] if truth["effect"] in {"bump", "slip_patch"} else ():
            found = finding["where"]["intervals"]
            near = min(found, key=lambda one: abs(one[0] - start), default=None)
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
    """Return by how many of its sigmas every number that was estimated is off."""
    found = []
    for truth, finding, _ in _matches(pairs):
        for name, parameter in truth["parameters"].items():
            said = finding["parameters"].get(name)
            if (
                said is None
                or isinstance(parameter["value"], list)
                or name in {"phase", "order", "above", "time", "direction"}
            ):
                continue
            if said["sigma"] > 0.0:
                found.append((said["value"] - parameter["value"]) / said["sigma"])
    return found


def _matches(pairs: Iterable[tuple[Label, Answer]]) -> Iterable[tuple[Label, dict[str, Any], float]]:
    """Yield every true effect with the finding of its own name, and the sample period."""
    for label, answer in pairs:
        for truth in label["effects"]:
            for finding in answer["findings"]:
                if (finding["effect"], finding["component"]) == (truth["effect"], truth["component"]):
                    yield truth, finding, label.get("period", 0.02)


def _mean(values: Sequence[float]) -> float:
    return sum(values) / len(values) if values else math.nan
