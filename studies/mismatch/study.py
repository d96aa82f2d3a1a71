"""The study: worlds made or found, the tool asked about each, and what its answers are worth in one table."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

from rich.table import Table

from omnimate.mismatch import diagnose
from studies.figures import plot_efficiency, plot_errors, plot_reliability
from studies.mismatch import run, tables
from studies.mismatch.engines.cases import cases
from studies.mismatch.run import Answer, Answers, Progress, Tool, answered_by
from studies.mismatch.scoring.audit import Audit, audited, questions
from studies.mismatch.scoring.efficiency import efficiency
from studies.mismatch.scoring.judging import beyond_twins, reported_instead
from studies.mismatch.scoring.leave_one_out import concealing
from studies.mismatch.scoring.score import Score, pooled, scored
from studies.mismatch.worlds.world import AbsentError, Corpus, Request, World


def ask_tool(corpus: Corpus, jobs: int, progress: Progress, kept: Path | None = None) -> dict[str, Answer]:
    """Return the tool's answers to all cases of a corpus, by case; the file `kept` receives each at once."""
    wanted = {case: corpus.question(case) for case in corpus.labels}
    with progress(f"{corpus.world.name}: diagnosing") as report:
        answers = run.ask_all(corpus.world.ask, wanted, jobs, report, kept)
    return {case: answers[case] for case in wanted}


def ask_without(corpus: Corpus, jobs: int, progress: Progress) -> dict[str, Answer]:
    """Return what the tool answers to each case without the effect that is concealed in it."""
    wanted: dict[str, tuple[Tool, tuple[Path, dict[str, object]]]] = {
        case: (partial(diagnose, without=(effect,)), corpus.question(case))
        for case, effect in concealing(corpus.labels).items()
    }
    with progress(f"{corpus.world.name}: leaving out what is concealed") as report:
        return run.ask_all(answered_by, wanted, jobs, report)


def ask_engine(
    corpus: Corpus, answers: Answers, jobs: int, request: Request, progress: Progress
) -> list[Audit]:
    """Return how far the names reported in the truth's place lead when the engine drives them."""
    wanted = {
        question.name: question
        for question in questions(corpus.labels, answers, cases(request.quick), request.seed)
    }
    if not wanted:
        return []
    with progress("driving what was reported") as report:
        return list(run.ask_all(audited, wanted, jobs, report).values())


RESULT, RELIABILITY = "proof.json", "reliability.png"


def study(
    place: Path,
    worlds: Sequence[World],
    request: Request,
    jobs: int,
    progress: Progress,
    figures: Path | None = None,
    *,
    leave_one_out: bool = False,
) -> Iterator[Table | str]:
    """Carry the study out in a folder, and yield its tables and sentences as they are known.

    Raises:
        OmnimateError: The folder holds another corpus.
        PlotError: A figure cannot be written.
    """
    place.mkdir(parents=True, exist_ok=True)
    scores: list[Score] = []
    asked: list[tuple[Corpus, Answers]] = []
    answers: Answers
    for world in worlds:
        try:
            corpus = world.corpus(place, request, jobs, progress)
        except AbsentError as absent:
            yield str(absent)
            continue
        yield f"labels of {world.name}: {len(corpus.labels)}, SHA-256 {corpus.digest}"
        answers = ask_tool(corpus, jobs, progress, place / f"{world.name}.answers.jsonl")
        yield from _refused(answers)
        scores.append(scored(corpus, answers))
        asked.append((corpus, answers))
    if not scores:
        return
    columns = [*scores, *pooled(asked)]
    _write(place / RESULT, {"worlds": {score.name: score.as_json() for score in columns}})
    yield tables.worlds(columns)
    if figures is not None:
        _draw(scores, asked, figures)
    for corpus, answers in asked:
        if reported := reported_instead(corpus.labels, answers):
            yield tables.instead(corpus.world.title, reported)
        if any("open_loop" in answer for answer in answers.values()):
            yield tables.open_loop(corpus.world.title, corpus.labels, answers)
        if corpus.world.name == "engine":
            audits = ask_engine(corpus, answers, jobs, request, progress)
            yield tables.redriven(corpus.world.title, audits)
            if leave_one_out:
                unnamed = ask_without(corpus, jobs, progress)
                _write(place / "leave-one-out.json", unnamed)
                yield tables.missed("Leave one out", corpus.labels, unnamed)


def _draw(scores: Sequence[Score], asked: Sequence[tuple[Corpus, Answers]], figures: Path) -> None:
    plot_reliability({score.title: score.reliability for score in scores}, figures / RELIABILITY)
    for corpus, answers in asked:
        kinds = {label["kind"] for label in corpus.labels.values()}
        if "calibration" in kinds:
            _draw_open_loop(corpus, answers, figures / f"{corpus.world.name}.png")
        if "injected" in kinds:
            found = efficiency(corpus.labels, beyond_twins(corpus.labels, answers))
            plot_efficiency(found, figures / f"{corpus.world.name}.png", corpus.world.title)


def _draw_open_loop(corpus: Corpus, answers: Answers, path: Path) -> None:
    cases = [case for case in corpus.labels if "open_loop" in answers[case]]
    columns = {each: [answers[case]["open_loop"][each] for case in cases] for each in tables.ERRORS}
    plot_errors(cases, columns, path)


def _refused(answers: Answers) -> Iterator[str]:
    """Yield how many cases were refused, or made the tool fail."""
    refused = [
        f"{name}: {answer['says']}" for name, answer in answers.items() if answer["verdict"] == "error"
    ]
    if refused:
        yield f"{len(refused)} of {len(answers)} cases were refused or failed; the first: {refused[0]}"


def _write(path: Path, content: object) -> None:
    path.write_text(json.dumps(content, indent=1), encoding="utf-8")
