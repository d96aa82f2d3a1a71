"""The score: how often a tool's answers agree with labels that it has not seen. JSON in, rows out."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

SURE = 0.9  # probability from which an answer is sure
ASSERTED = 0.5  # probability from which a finding is an assertion
SET = 0.95  # probability of a credible set


@dataclass(frozen=True, slots=True)
class Row:
    """One line of the table.

    Attributes:
        name: Name of what was counted.
        hits: Number of cases in which it was so.
        of: Number of cases in which it could have been so.
        target: Share that is wanted; None for no target.
        most: Whether the target is an upper bound.
        note: Remark beside the figure.
    """

    name: str
    hits: int
    of: int
    target: float | None = None
    most: bool = False
    note: str = ""

    @property
    def share(self) -> float:
        """Hits over all cases; nan without any case."""
        return self.hits / self.of if self.of else math.nan

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson's 95 % interval of the share; nan without any case."""
        if not self.of:
            return math.nan, math.nan
        z, n, p = 1.96, self.of, self.share
        middle, width = p + z * z / (2 * n), z * math.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
        return (middle - width) / (1 + z * z / n), (middle + width) / (1 + z * z / n)

    @property
    def verdict(self) -> str:
        """Whether the target is reached, in words; empty without a target or any case."""
        if self.target is None or not self.of:
            return ""
        reached = self.share <= self.target if self.most else self.share >= self.target
        return "reached" if reached else "NOT REACHED"


Label = dict[str, Any]
Answer = dict[str, Any]


def rows(labels: Mapping[str, Label], answers: Mapping[str, Answer], ease: float = 1.0) -> list[Row]:
    """Return the table of a corpus.

    Args:
        labels: Label of each case, as `labels.json` holds it.
        answers: Answer to each case, as `Diagnosis.as_json` gives it; cases without one do not count.
        ease: Factor on the targets; upper bounds are divided by it.
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
    unknown = [(label, answer) for label, answer in pairs if label["kind"] == "unknown"]
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
        Row("parameter within 2 sigma", sum(abs(deviation) <= 2.0 for deviation in z), len(z), 0.95),
        Row("held-out residual after <= 1.05", sum(residual <= 1.05 for residual in after), len(after), 0.95),
        Row("unknown called unknown", sum(says_unknown(*pair) for pair in unknown), len(unknown), 0.9),
    ]


def asserted(answer: Answer, least: float) -> list[dict[str, Any]]:
    """Return the findings of at least a probability."""
    return [finding for finding in answer["findings"] if finding["probability"] >= least]


def fits(effect: str, component: str, truth: Label) -> bool:
    """Say whether an effect on a component is the truth, or one that the drive cannot separate from it."""
    right = {(truth["effect"], truth["component"])}
    right |= {(other["effect"], other["component"]) for other in truth.get("acceptable", ())}
    if truth["effect"] == "unknown" and effect == "unknown":
        return True
    return (effect, component) in right


def wrong(finding: dict[str, Any], label: Label) -> bool:
    """Say whether a finding is neither one of the label's effects nor one that looks like them."""
    extra = label.get("acceptable_findings", [])
    if any(
        (finding["effect"], finding["component"]) == (true["effect"], true["component"]) for true in extra
    ):
        return False
    return not any(fits(finding["effect"], finding["component"], truth) for truth in label["effects"])


def first_right(label: Label, answer: Answer) -> bool:
    """Say whether the first findings are the label's effects, as far as the drive can separate them."""
    first = answer["findings"][: max(1, len(label["effects"]))]
    return bool(first) and not any(wrong(finding, label) for finding in first)


def first_exact(label: Label, answer: Answer) -> bool:
    """Say whether the first findings are the label's effects by name and component."""
    truth = {(effect["effect"], effect["component"]) for effect in label["effects"]}
    first = {(finding["effect"], finding["component"]) for finding in answer["findings"][: len(truth)]}
    return first == truth


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
    return len(likely) == len(label["effects"]) and all(matched)


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


def says_unknown(label: Label, answer: Answer) -> bool:
    """Say whether the first assertion is that something unknown acts."""
    first = asserted(answer, ASSERTED)[:1]
    return any(finding["effect"] == "unknown" for finding in first) and bool(label["effects"])


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
            if estimate["sigma"] > 0.0:
                errors.append((estimate["value"] - parameter["value"]) / estimate["sigma"])
    return errors


def _matches(pairs: Iterable[tuple[Label, Answer]]) -> Iterable[tuple[Label, dict[str, Any], float]]:
    """Yield every true effect, the finding of the same name, and the sample period [s]."""
    for label, answer in pairs:
        for truth in label["effects"]:
            for finding in answer["findings"]:
                if (finding["effect"], finding["component"]) == (truth["effect"], truth["component"]):
                    yield truth, finding, label.get("period", 0.02)


def _mean(values: Sequence[float]) -> float:
    return sum(values) / len(values) if values else math.nan
