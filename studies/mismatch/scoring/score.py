"""The score of a world: how often answers agree with labels that the tool has not seen. JSON in, rows out."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from statistics import fmean, geometric_mean
from typing import Any

from scipy.stats import binomtest

from studies.mismatch.run import Answers
from studies.mismatch.scoring.efficiency import efficiency
from studies.mismatch.scoring.judging import (
    ASSERTED,
    SURE,
    Answer,
    Label,
    all_right,
    asserted,
    beyond_twins,
    credible,
    deviations,
    events,
    first_exact,
    first_right,
    fits,
    in_set,
    is_found,
    says_unknown,
    wrong,
)
from studies.mismatch.worlds.world import Corpus


def wilson(hits: int, of: int) -> tuple[float, float]:
    """Return the 95 % interval of a share, Wilson (1927); nan without any case."""
    if not of:
        return math.nan, math.nan
    interval = binomtest(hits, of).proportion_ci(method="wilson")
    return float(interval.low), float(interval.high)


# Bounds of the bins: finer where answers are sure, because that is where a false one does harm.
EDGES = (0.0, 0.1, 0.25, 0.5, 0.75, 0.9, 0.99, 1.0)


@dataclass(frozen=True, slots=True)
class Bin:
    """Findings of about the same probability."""

    said: float  # mean of their probabilities
    right: int  # number of those that are right
    of: int  # number of all

    @property
    def share(self) -> float:
        return self.right / self.of

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson's 95 % interval of the share."""
        return wilson(self.right, self.of)

    def as_json(self) -> dict[str, Any]:
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


STRONG = 10.0  # standard deviations from which an injected effect is expected to be named


@dataclass(frozen=True, slots=True)
class Line:
    """A figure of the score: a share of cases, or a size such as a ratio of two errors."""

    name: str  # name of the figure
    value: float  # its value; nan where nothing gives it
    target: float | None = None  # value that is wanted; None for no target
    most: bool = True  # whether the target is an upper bound
    note: str = ""  # what stands in the table in place of a size
    # of a share, in how many cases it was so, and in how many it could have been so
    counted: tuple[int, int] | None = None

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson's 95 % interval of a share; nan without any case."""
        return wilson(*(self.counted or (0, 0)))

    @property
    def text(self) -> str:
        if math.isnan(self.value):
            return "-"
        return "{} of {}".format(*self.counted) if self.counted else self.note or f"{self.value:.3g}"

    @property
    def is_missed(self) -> bool:
        """Whether a target is not reached."""
        if self.target is None or math.isnan(self.value):
            return False
        return self.value > self.target if self.most else self.value < self.target

    def as_json(self) -> dict[str, Any]:
        shown: dict[str, Any] = {"value": _number(self.value)}
        if self.counted:
            hits, of = self.counted
            interval = [_number(bound) for bound in self.interval]
            shown = {"hits": hits, "of": of, "share": _number(self.value), "interval": interval}
        wanted = {"target": self.target, "most": self.most, "missed": self.is_missed, "note": self.note}
        return {"name": self.name, **shown, **wanted}


def share(name: str, hits: Sequence[bool], target: float | None = None, *, most: bool = False) -> Line:
    """Return how often something was so, of all cases in which it could have been so."""
    counted = sum(hits), len(hits)
    return Line(name, counted[0] / counted[1] if hits else math.nan, target, most, counted=counted)


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None


def rows(labels: Mapping[str, Label], answers: Mapping[str, Answer]) -> list[Line]:
    """Return the score of a world; every world has the same lines, those without a case empty.

    Labels and answers are JSON, by case; cases without an answer do not count.
    """
    answers = beyond_twins(labels, answers)
    pairs = [(label, answers[name]) for name, label in labels.items() if name in answers]
    nulls = [(label, answer) for label, answer in pairs if label["kind"] == "null"]
    known = [(label, answer) for label, answer in pairs if label["kind"] in {"single", "masked"}]
    multi = [(label, answer) for label, answer in pairs if label["kind"] == "multi"]
    both = [(label, answer) for label, answer in multi if len(label["effects"]) == 2]
    unknown = [(label, answer) for label, answer in pairs if label["kind"] == "unknown"]
    sure = [wrong(finding, label) for label, answer in pairs for finding in asserted(answer, SURE)]
    sets = [in_set(truth, answer) for label, answer in known + multi for truth in label["effects"]]
    sizes = [len(credible(finding)) for _, answer in known + multi for finding in asserted(answer, ASSERTED)]
    heldout = [answer["fit"]["heldout"] for _, answer in known if answer["fit"]]
    outside = [truth["outside"] for label, _ in unknown for truth in label["effects"] if "outside" in truth]
    onset, iou = events(known + multi)
    z = deviations(known + multi)
    alarms = [any(wrong(item, label) for item in asserted(answer, ASSERTED)) for label, answer in nulls]
    return [
        share("false alarm on a null", alarms, 0.01, most=True),
        share("said 0.9 or more, and wrong", sure, 0.01, most=True),
        share("said 0.9 or more, and right", [not item for item in sure], 0.97),
        share("one effect: right first", [first_right(*pair) for pair in known], 0.95),
        share("one effect: exactly the truth first", [first_exact(*pair) for pair in known]),
        share("two at once: exactly right", [all_right(*pair) for pair in both], 0.85),
        share("95 % set holds the truth", sets, 0.95),
        Line("mean size of the set", _mean(sizes)),
        share("event onset within two samples", onset, 0.9),
        share("interval overlap of 0.8", iou, 0.9),
        share("parameter within 2 sigma", [abs(deviation) <= 2.0 for deviation in z], 0.95),
        _heldout(heldout),
        share("held-out residual after <= 1.05", [item["after"] <= 1.05 for item in heldout], 0.95),
        share("unknown called unknown", [says_unknown(*pair) for pair in unknown], 0.9),
        Line("unknown: left by the best curve in one quantity", _mean(outside)),
        *_of_injections(labels, answers),
        *_of_calibrations(pairs),
    ]


def _of_injections(labels: Mapping[str, Label], answers: Mapping[str, Answer]) -> list[Line]:
    """Return the lines about effects that were injected into real recordings."""
    injected = {name: label for name, label in labels.items() if label["kind"] == "injected"}
    pairs = [(label, answers[name]) for name, label in injected.items() if name in answers]
    strong = [pair for pair in pairs if pair[0]["strength"] >= STRONG]
    new = [any(wrong(finding, label) for finding in asserted(answer, ASSERTED)) for label, answer in pairs]
    half = efficiency(injected, answers).half
    return [
        share("injected, 10 sigma: right first or in its set", [*map(_is_led, strong)], 0.95),
        Line("injected: strength found half of the time over 5 sigma", half / 5.0, 1.5),
        share("injected: a wrong finding that the twin has not", new, 0.01, most=True),
    ]


def _is_led(pair: tuple[Label, Answer]) -> bool:
    """Say whether the first finding is the injected effect, or holds it in its set."""
    label, answer = pair
    first = {**answer, "findings": answer["findings"][:1]}
    return first_right(label, answer) or is_found(label, first)


def _of_calibrations(pairs: Sequence[tuple[Label, Answer]]) -> list[Line]:
    """Return the lines about real recordings beside plain least squares."""
    real = [(label, answer) for label, answer in pairs if label["kind"] == "calibration"]
    asserted_numbers = [
        any(fits(finding["effect"], finding["component"], truth) for finding in asserted(answer, ASSERTED))
        for label, answer in real
        for truth in label["effects"]
    ]
    squares: dict[str, list[tuple[float, float]]] = {}
    for label, answer in real:
        if "open_loop" in answer:
            errors = answer["open_loop"]
            squares.setdefault(label["set"], []).append((errors["found"] ** 2, errors["least squares"] ** 2))
    ratios = [
        math.sqrt(sum(diagnosed for diagnosed, _ in halves) / sum(plain for _, plain in halves))
        for halves in squares.values()
    ]
    return [
        share("5 sigma by least squares: asserted", asserted_numbers, 1.0),
        Line("open loop over least squares, worst set", max(ratios, default=math.nan), 1.0),
        Line("open loop over least squares, geometric mean", _mean(ratios, geometric_mean), 0.95),
    ]


def _heldout(residuals: Sequence[Mapping[str, float]]) -> Line:
    """Return the geometric means of held-out residuals, before and after."""
    before, after = (
        _mean([change[when] for change in residuals], geometric_mean) for when in ("before", "after")
    )
    return Line("held-out residual, before -> after", after / before, note=f"{before:.2f} -> {after:.2f}")


def _mean(values: Sequence[float], mean: Callable[[Sequence[float]], float] = fmean) -> float:
    return mean(values) if values else math.nan


@dataclass(frozen=True, slots=True)
class Score:
    """What a tool's answers about a world are worth."""

    name: str  # name of the world
    title: str  # what tables call it
    cases: int  # number of cases
    digest: str  # SHA-256 of the labels; empty where worlds are pooled
    lines: Sequence[Line]  # the lines of the table, the same in every world
    reliability: Sequence[Bin]  # what was said against what is right

    def as_json(self) -> dict[str, Any]:
        return {
            "title": self.title,
            "cases": self.cases,
            "labels": self.digest,
            "lines": [line.as_json() for line in self.lines],
            "reliability": [interval_bin.as_json() for interval_bin in self.reliability],
        }


def scored(corpus: Corpus, answers: Answers) -> Score:
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
