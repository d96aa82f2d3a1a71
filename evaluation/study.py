"""The study: corpora written, tools asked, and what their answers are worth, a table after the other."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING

from omnimate.evaluation import tables
from omnimate.evaluation.corpora import has_contact_engine, seal, write_corpora
from omnimate.evaluation.questions import (
    ablations,
    ask_engine,
    ask_others,
    ask_tool,
    ask_without,
    baselines,
)

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from pathlib import Path

    from rich.table import Table

    from omnimate.evaluation.corpora import Corpus, Request
    from omnimate.evaluation.progress import Progress
    from omnimate.evaluation.questions import Answers, Tool


@dataclass(frozen=True, slots=True)
class Comparisons:
    """What is asked beside the tool itself: True all cases, False none, None a few where little is wanted.

    Attributes:
        baselines: Whether plain methods are asked.
        ablations: Whether the tool without each of its parts is asked.
        leave_one_out: Whether the tool is asked without the effect that is concealed.
    """

    baselines: bool | None
    ablations: bool | None
    leave_one_out: bool | None


def study(
    place: Path, request: Request, comparisons: Comparisons, jobs: int, progress: Progress
) -> Iterator[Table | str]:
    """Carry the study out in a folder, and yield its tables and sentences as they are known.

    Raises:
        OmnimateError: The folder holds another corpus, or one that was not finished.
    """
    corpora = []
    for corpus in write_corpora(place, request, jobs, progress):
        corpora.append(corpus)
        yield f"labels of the {corpus.title}: {len(corpus.labels)}, SHA-256 {seal(corpus)}"
    if request.contact and not has_contact_engine():
        yield "MuJoCo is not installed (pip install 'omnimate[mujoco]'): its part of the corpus is left out"
    answers = ask_tool(corpora, jobs, progress, place / "answers.jsonl")
    _write(place / "answers.json", answers)
    yield from _worth(corpora, answers)
    for corpus in corpora:
        if corpus.name == "own":
            audits = ask_engine(corpus, answers, jobs, request, progress)
            yield tables.redriven(corpus.title, audits)
    plain = {"Baselines": (comparisons.baselines, baselines), "Ablations": (comparisons.ablations, ablations)}
    for title, (wanted, tools) in plain.items():
        for corpus in _portion(corpora, quick=request.quick, wanted=wanted):
            yield _compare(title, tools(), answers, corpus, place, jobs, progress)
    for corpus in _portion(corpora, quick=request.quick, wanted=comparisons.leave_one_out):
        unnamed = ask_without(corpus, jobs, progress)
        _write(place / f"leave-one-out-{corpus.name}.json", unnamed)
        yield tables.missed(f"Leave one out: {corpus.title}", corpus.labels, unnamed)


def _worth(corpora: Sequence[Corpus], answers: Answers) -> Iterator[Table | str]:
    """Yield how often the tool is right about each corpus."""
    refused = [
        f"{name}: {answer['says']}" for name, answer in answers.items() if answer["verdict"] == "error"
    ]
    if refused:
        yield f"{len(refused)} of {len(answers)} cases were refused as bad input; the first: {refused[0]}"
    for corpus in corpora:
        yield tables.shown(corpus.title, corpus.labels, answers, corpus.ease)
        yield tables.instead(corpus.title, corpus.labels, answers)


def _portion(corpora: Sequence[Corpus], *, quick: bool, wanted: bool | None) -> Sequence[Corpus]:
    """Return what to ask more about: everything, nothing, or a few cases where little time is to be spent."""
    if wanted is None and quick:
        return [corpora[0].few()]
    return [] if wanted is False else corpora


def _compare(
    title: str,
    tools: Mapping[str, Tool],
    answers: Answers,
    corpus: Corpus,
    place: Path,
    jobs: int,
    progress: Progress,
) -> Table:
    """Return what other tools' answers are worth beside the tool's."""
    others = ask_others(title.lower(), corpus, tools, jobs, progress)
    _write(place / f"{title.lower()}-{corpus.name}.json", others)
    return tables.compared(
        f"{title}: {corpus.title}", corpus.labels, {"diagnose": answers, **others}, corpus.ease
    )


def _write(path: Path, answers: object) -> None:
    path.write_text(json.dumps(answers), encoding="utf-8")
