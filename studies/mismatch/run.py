"""Questions answered one by one in several processes, with answers that survive a stop."""

from __future__ import annotations

import json
from concurrent.futures import ProcessPoolExecutor
from typing import TYPE_CHECKING, Any, TypeVar

from threadpoolctl import threadpool_limits

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from pathlib import Path

Question = TypeVar("Question")
Reply = TypeVar("Reply")


def _pool(jobs: int) -> ProcessPoolExecutor:
    """Return a pool of processes that use one thread each for matrices, as all cores are busy already."""
    return ProcessPoolExecutor(jobs, initializer=threadpool_limits, initargs=(1,))


def ask_all(
    ask: Callable[[Question], Reply],
    questions: Mapping[str, Question],
    jobs: int,
    report: Callable[[int, int], None],
    kept: Path | None = None,
) -> dict[str, Reply]:
    """Return the answers to questions, by name.

    Args:
        ask: Function that answers one question.
        questions: Questions, by name.
        jobs: Number of processes.
        report: Function that is called with the number of answers and the number of all questions.
        kept: File that receives every answer as a line of JSON; what it holds already is not asked again.
    """
    answers: dict[str, Reply] = {} if kept is None else _known(kept)
    waiting = {name: question for name, question in questions.items() if name not in answers}
    with _pool(jobs) as pool:
        for name, answer in zip(waiting, pool.map(ask, waiting.values()), strict=True):
            answers[name] = answer
            report(len(answers), len(questions))
            if kept is not None:
                with kept.open("a", encoding="utf-8") as file:
                    file.write(json.dumps([name, answer]) + "\n")
    return answers


def _known(kept: Path) -> dict[str, Any]:
    """Return the answers in a file, and remove a last line that is not complete."""
    if not kept.exists():
        return {}
    text = kept.read_text(encoding="utf-8")
    whole = text[: text.rfind("\n") + 1]
    if whole != text:
        kept.write_text(whole, encoding="utf-8")
    return dict(json.loads(line) for line in whole.splitlines())
