"""Asking the mismatch tool, the tool without one of its parts, and plainer methods about a corpus."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from omnimate.logs.folder import load_recording
from omnimate.mismatch import Diagnosis, diagnose
from omnimate.mismatch.baselines import baseline
from omnimate.mismatch.parts import ABLATIONS
from omnimate.mismatch.sparse import METHODS
from omnimate.proof import run
from omnimate.proof.audit import audited, questions
from omnimate.proof.cases import cases
from omnimate.proof.leave_one_out import concealing
from omnimate.vehicle.errors import OmnimateError
from omnimate.vehicle.recording import Recording

if TYPE_CHECKING:
    from pathlib import Path

    from omnimate.evaluation.corpora import Corpus, Request
    from omnimate.evaluation.progress import Progress
    from omnimate.proof.audit import Audit

Tool = Callable[[Sequence[Recording]], Diagnosis]
Answer = dict[str, Any]
Answers = Mapping[str, Answer]


def answered(question: tuple[Path, Tool]) -> Answer:
    """Return a tool's answer to all recordings of a case, as JSON; a refusal is an answer too."""
    folder, tool = question
    recordings = [place for place in sorted(folder.iterdir()) if place.is_dir()]
    try:
        return tool([load_recording(recording) for recording in recordings]).as_json()
    except OmnimateError as error:
        return {"verdict": "error", "says": str(error), "findings": [], "fit": None}


def ask_tool(
    corpora: Sequence[Corpus], jobs: int, progress: Progress, kept: Path | None = None
) -> dict[str, Answer]:
    """Return the tool's answers to all cases of all corpora, by case.

    Args:
        corpora: The corpora.
        jobs: How many processes answer at once.
        progress: Is shown how many cases are answered.
        kept: File that receives every answer at once; what it holds is not asked again.
    """
    wanted = {case: (corpus.folder / case, diagnose) for corpus in corpora for case in corpus.labels}
    with progress("diagnosing") as report:
        return run.ask_all(answered, wanted, jobs, report, kept)


def ask_others(
    doing: str, corpus: Corpus, tools: Mapping[str, Tool], jobs: int, progress: Progress
) -> dict[str, Answers]:
    """Return the answers of other tools to all cases of a corpus, by tool and case."""
    wanted = {
        f"{name} {case}": (corpus.folder / case, tool)
        for name, tool in tools.items()
        for case in corpus.labels
    }
    with progress(doing) as report:
        answers = run.ask_all(answered, wanted, jobs, report)
    return {name: {case: answers[f"{name} {case}"] for case in corpus.labels} for name in tools}


def ask_without(corpus: Corpus, jobs: int, progress: Progress) -> dict[str, Answer]:
    """Return what the tool answers to each case without the effect that is concealed in it."""
    wanted = {
        case: (corpus.folder / case, partial(diagnose, without=(effect,)))
        for case, effect in concealing(corpus.labels).items()
    }
    with progress("leaving out what is concealed") as report:
        return run.ask_all(answered, wanted, jobs, report)


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


def baselines() -> dict[str, Tool]:
    """Return the plain methods."""
    return {name: partial(baseline, name=name) for name in METHODS}


def ablations() -> dict[str, Tool]:
    """Return the tool without each of its parts."""
    return {name: partial(diagnose, parts=parts) for name, parts in ABLATIONS.items()}
