"""`python -m studies rules`: what each rule of the diagnosis earns, by leaving out one at a time.

A rule is a piece of the method that decides, and that no equation of the model demands.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Annotated, Any
from unittest.mock import patch

import numpy as np
import typer
from rich.table import Table

from omnimate.cli.console import progress_bar
from omnimate.cli.tables import new_table, show
from omnimate.mismatch.answer.doubts import SUREST
from omnimate.mismatch.answer.omnibus import Leftover
from omnimate.mismatch.scans.obstacles import no_obstacles
from omnimate.vehicle.errors import OmnimateError
from studies.mismatch import run
from studies.mismatch.run import Answer, Answers, Question, answered
from studies.mismatch.scoring.judging import ASSERTED, asserted, names_of
from studies.mismatch.scoring.score import rows
from studies.mismatch.worlds.registry import chosen
from studies.mismatch.worlds.world import Label, Request

SHOWN = (
    "false alarm on a null",
    "said 0.9 or more, and wrong",
    "one effect: right first",
    "two at once: exactly right",
    "95 % set holds the truth",
    "unknown called unknown",
)
Rule = tuple[str, Any]  # the place of a function or constant, and what stands there without the rule


def _always(answer: object) -> Callable[..., Any]:
    return lambda *_, **__: answer


EVIDENCE, FIT = "omnimate.mismatch.evidence.search", "omnimate.mismatch.evidence.conditional_fit"
SEARCH, ANSWER = "omnimate.mismatch.investigate", "omnimate.mismatch.answer"
RULES: dict[str, Rule] = {
    "held-out density": (f"{FIT}.heldout_log_density_gain", _always(math.inf)),
    "strongest seconds held out": (
        f"{FIT}.ConditionalFit._strongest_seconds",
        lambda _, gain: np.zeros(len(gain), np.int64),
    ),
    "no nearly cancelling pair": (f"{FIT}.ConditionalFit._nearly_cancels", _always(False)),
    "members' discrepancies": (
        f"{FIT}.ConditionalFit._member_discrepancies",
        lambda self: np.zeros((len(self.candidates.regression.white), 1)),
    ),
    "an event's own discrepancy": (
        f"{FIT}.ConditionalFit._discrepancy_weights",
        lambda _, _part, after: np.ones(len(after)),
    ),
    "overdispersion": (f"{FIT}.ConditionalFit._overdispersion", _always(1.0)),
    "an unknown shows in a channel": (f"{FIT}.MIN_UNKNOWN_EXPLAINED", 0.0),
    "unknown needs a margin": (f"{EVIDENCE}.NAMELESS_MARGIN", 0.0),
    "pairs that mask each other": (f"{EVIDENCE}._best_pair", _always(None)),
    "exchange of members": (f"{EVIDENCE}._exchange", lambda _, members: members),
    "merging two members": (f"{EVIDENCE}._merge_two_members", lambda _, members: members),
    "one in the place of two": (f"{ANSWER}.rivals.replacements_of_two", _always(())),
    "effects of one kind cancel": (f"{EVIDENCE}._without_what_cancels", lambda _, members: members),
    "certain events at once": (f"{EVIDENCE}._with_certain_events", lambda _, __, first: [first]),
    "odds that others raise": (
        "omnimate.mismatch.evidence.candidates.Candidates.odds",
        lambda self, candidate, _: self.terms[candidate].odds,
    ),
    "past innovations as regressors": (f"{SEARCH}.LAG_SIZE", 1e-9),
    "disturbed windows": (
        f"{SEARCH}.inflate_disturbed_windows",
        lambda regression, _: (list(regression.windows), 0),
    ),
    "trains of obstacles": (f"{SEARCH}.find_obstacles", no_obstacles),
    "startup nuisances": (f"{SEARCH}.startup_nuisances", _always([])),
    "moments refined": (f"{SEARCH}.refine", lambda _, __, candidate: candidate),
    "bounds refined": ("omnimate.mismatch.scans.events._bounded", lambda _, __, offers: list(offers)),
    "pushes that last": ("omnimate.mismatch.scans.events._lasting", _always([])),
    "a rejected size": (f"{SEARCH}._is_accepted", _always(True)),
    "sizes of all windows agree": (f"{SEARCH}._agree", _always(True)),
    "an unknown predicts better": (f"{SEARCH}.predicts_better", _always(True)),
    "learned laws": (f"{SEARCH}.learned", _always([])),
    "bootstrap of stretches": (
        f"{ANSWER}.rivals._draws",
        lambda posterior, _: np.ones((1, int(posterior.candidates.stretch.max()) + 1)),
    ),
    "doubt: misfit": (f"{ANSWER}.doubts.MISFIT", math.inf),
    "doubt: predicted leftover": (
        f"{ANSWER}.doubts._are_predicted",
        lambda parts, *_: [False] * len(parts),
    ),
    "doubt: discrepancies": (
        f"{ANSWER}.doubts._are_discrepancies",
        lambda terms, _: [False] * len(terms),
    ),
    "doubt: an unknown's omnibus test": (f"{ANSWER}.findings.surest_unknown", _always(SUREST)),
    "doubt: a calibrated number where the error varies": (f"{ANSWER}.doubts._lasting", _always(set())),
    "omnibus test": (f"{ANSWER}.answer.leftover", _always(Leftover(1.0))),
    "relevance": (f"{ANSWER}.answer.relevant", lambda present, *_: (tuple(present), ())),
    "averaged calibration": (f"{ANSWER}.answer.averaged", lambda fit: fit.calibrated),
    "outlying poses": (
        "omnimate.mismatch.recording.signals.pose_outliers",
        lambda pose, _: np.zeros(len(pose), bool),
    ),
}
WHOLE = "nothing left out"
TOGETHER = " + "  # between the names of rules that are left out at once


def ask_without(asked: tuple[str, Question]) -> Answer:
    """Return the answer to a question without a rule, or without several."""
    rule, question = asked
    if rule == WHOLE:
        return answered(question)
    with ExitStack() as left_out:
        for name in rule.split(TOGETHER):
            left_out.enter_context(patch(*RULES[name]))
        return answered(question)


def table(labels: Mapping[str, Label], answers: Mapping[str, Answers]) -> Table:
    """Return a line for each rule that is left out: how many cases assert something else, and the score."""
    shown = new_table(f"What each rule earns in {len(labels)} cases", ("without",), ("other names", *SHOWN))
    whole = answers[WHOLE]
    for rule, answers_without in answers.items():
        lines = {line.name: line for line in rows(labels, answers_without)}
        pairs = [
            [asserted(by_case[case], ASSERTED) for by_case in (answers_without, whole)] for case in labels
        ]
        other = sum(names_of(findings) != names_of(others) for findings, others in pairs)
        shown.add_row(rule, str(other), *(lines[name].text.replace(" of ", "/") for name in SHOWN))
    return shown


def rules(
    world: Annotated[list[str], typer.Option(help="A world to ask about, as in `prove`.")],
    folder: Annotated[Path, typer.Option("--out", help="Keep recordings and answers here.")],
    rule: Annotated[
        list[str] | None,
        typer.Option(help="A rule to leave out, or 'one + another' at once; each one where none is named."),
    ] = None,
    cases: Annotated[int | None, typer.Option(help="Cases of each world.", min=1)] = None,
    data: Annotated[Path, typer.Option(help="Folder of labelled sets.")] = Path("../shared/data"),
    jobs: Annotated[int, typer.Option(help="Processes that work at once.", min=1)] = 2,
    seed: Annotated[int, typer.Option(help="Seed of everything that is drawn by chance.", min=0)] = 1,
) -> None:
    """Leave the rules of the diagnosis out, one at a time, and count what that changes."""
    wanted = [*(rule or RULES)]
    if unknown := {name for names in wanted for name in names.split(TOGETHER)} - RULES.keys():
        raise OmnimateError(f"no rule {', '.join(sorted(unknown))}; expected {', '.join(RULES)}")
    folder.mkdir(parents=True, exist_ok=True)
    labels: dict[str, Label] = {}
    questions: dict[str, Question] = {}
    for chosen_world in chosen(data, world):
        corpus = chosen_world.corpus(folder, Request(seed, cases), jobs, progress_bar)
        labels.update(corpus.labels)
        questions.update({case: corpus.question(case) for case in corpus.labels})
    wanted = [WHOLE, *wanted]
    asked = {f"{case} without {name}": (name, questions[case]) for name in wanted for case in questions}
    with progress_bar("leaving out one rule at a time") as report:
        replies = run.ask_all(ask_without, asked, jobs, report, folder / "rules.jsonl")
    answers = {name: {case: replies[f"{case} without {name}"] for case in questions} for name in wanted}
    show(table(labels, answers))
