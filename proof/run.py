"""Running a tool over a corpus: each case in a process of its own, its answer as JSON."""

from __future__ import annotations

import hashlib
import json
import random
from concurrent.futures import ProcessPoolExecutor
from typing import TYPE_CHECKING, Any, TypeVar

from threadpoolctl import threadpool_limits

from proof.cases import cases, seed_of
from proof.corpus import make

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from pathlib import Path

Answer = dict[str, Any]
Question = TypeVar("Question")
Reply = TypeVar("Reply")


def write_corpus(
    folder: Path, jobs: int, tell: Callable[[int, int], None], *, quick: bool, seed: int, part: float = 1.0
) -> dict[str, Any]:
    """Write the corpus of the independent engine into a folder; return its labels.

    Args:
        folder: for a folder of each case; it must not hold any yet.
        jobs: processes.
        tell: is told how many are done, of how many.
        quick: the small corpus.
        seed: of all that is drawn by chance.
        part: share of the cases to take, drawn by chance.
    """
    wanted = cases(quick)
    folder.mkdir(parents=True)
    count = max(1, round(part * len(wanted)))
    numbers = sorted(random.Random(seed).sample(range(len(wanted)), count))  # noqa: S311  # no secret
    folders = [folder / f"own-{number:04d}" for number in numbers]
    labels = {}
    with _pool(jobs) as pool:
        seeds = [seed_of(seed, number) for number in numbers]
        made = pool.map(make, folders, [wanted[number] for number in numbers], seeds)
        for own, label in zip(folders, made, strict=True):
            labels[own.name] = label
            tell(len(labels), count)
    return labels


def _pool(jobs: int) -> ProcessPoolExecutor:
    """Return processes whose matrices take one thread each: more would fight over the same cores."""
    return ProcessPoolExecutor(jobs, initializer=threadpool_limits, initargs=(1,))


def sealed(labels: dict[str, Any], path: Path) -> str:
    """Write labels apart from the recordings; return their SHA-256, known before any tool runs."""
    text = json.dumps(labels, indent=1, sort_keys=True)
    path.write_text(text, encoding="utf-8")
    return hashlib.sha256(text.encode()).hexdigest()


def asked(
    ask: Callable[[Question], Reply],
    questions: Mapping[str, Question],
    jobs: int,
    tell: Callable[[int, int], None],
    kept: Path | None = None,
) -> dict[str, Reply]:
    """Return the answers to questions, by name.

    Args:
        ask: what is asked, as a folder of recordings and a tool, to its answer.
        questions: by name.
        jobs: processes.
        tell: is told how many are done, of how many.
        kept: file to which every answer, then JSON, is added as a line; what it holds is not asked again.
    """
    answers: dict[str, Reply] = {} if kept is None else _known(kept)
    waiting = {name: question for name, question in questions.items() if name not in answers}
    with _pool(jobs) as pool:
        for name, answer in zip(waiting, pool.map(ask, waiting.values()), strict=True):
            answers[name] = answer
            tell(len(answers), len(questions))
            if kept is not None:
                with kept.open("a", encoding="utf-8") as file:
                    file.write(json.dumps([name, answer]) + "\n")
    return answers


def _known(kept: Path) -> dict[str, Any]:
    """Return the answers in a file, and drop the line that a stop may have left half written."""
    if not kept.exists():
        return {}
    text = kept.read_text(encoding="utf-8")
    whole = text[: text.rfind("\n") + 1]
    if whole != text:
        kept.write_text(whole, encoding="utf-8")
    return dict(json.loads(line) for line in whole.splitlines())
