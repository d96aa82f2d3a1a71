"""The study: worlds made or found, the tool asked about each, and what its answers are worth in one table."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

from studies.figures.efficiency import plot_efficiency
from studies.figures.position_errors import plot_errors
from studies.figures.reliability import plot_reliability
from studies.mismatch import tables
from studies.mismatch.asking import ask_engine, ask_tool, ask_without
from studies.mismatch.scores import Score, pooled, scored
from studies.mismatch.scoring.efficiency import efficiency
from studies.mismatch.scoring.judging import beyond_twins, reported_instead
from studies.mismatch.worlds.world import AbsentError

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path

    from rich.table import Table

    from studies.mismatch.asking import Answers
    from studies.mismatch.progress import Progress
    from studies.mismatch.worlds.world import Corpus, Request, World

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

    Args:
        place: Folder that keeps recordings, labels, answers and the table.
        worlds: The worlds; one that is not here is left out, and that is said.
        request: How much of each.
        jobs: How many processes work at once.
        progress: Is shown how far the study is.
        figures: Folder for the reliability diagrams; None for none.
        leave_one_out: Whether the tool is asked about the engine's cases without what is concealed, too.

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
            plot_efficiency(found, figures / f"{corpus.world.name}.png", title=corpus.world.title)


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
