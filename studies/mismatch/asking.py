"""Asking the tool about all cases of a corpus, in several processes."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from omnimate.mismatch import diagnose
from studies.mismatch import run
from studies.mismatch.engines.cases import cases
from studies.mismatch.questions import Answer, answered_by
from studies.mismatch.scoring.audit import audited, questions
from studies.mismatch.scoring.leave_one_out import concealing

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from studies.mismatch.progress import Progress
    from studies.mismatch.questions import Tool
    from studies.mismatch.scoring.audit import Audit
    from studies.mismatch.worlds.world import Corpus, Request

    Answers = Mapping[str, Answer]


def ask_tool(corpus: Corpus, jobs: int, progress: Progress, kept: Path | None = None) -> dict[str, Answer]:
    """Return the tool's answers to all cases of a corpus, by case.

    Args:
        corpus: The corpus.
        jobs: How many processes answer at once.
        progress: Is shown how many cases are answered.
        kept: File that receives every answer at once; what it holds is not asked again.
    """
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
