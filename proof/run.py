"""Running a tool over a corpus: each case in a process of its own, its answer as JSON."""

from __future__ import annotations

import hashlib
import json
from concurrent.futures import ProcessPoolExecutor
from typing import TYPE_CHECKING, Any, TypeVar

from proof.corpus import cases, make

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from pathlib import Path

Answer = dict[str, Any]
Question = TypeVar("Question")


def write_corpus(
    folder: Path, jobs: int, tell: Callable[[int, int], None], *, quick: bool, seed: int
) -> dict[str, Any]:
    """Write the corpus of the independent engine into a folder; return its labels."""
    wanted = cases(quick)
    folder.mkdir(parents=True, exist_ok=True)
    names = [f"own-{number:04d}" for number in range(len(wanted))]
    labels = {}
    with ProcessPoolExecutor(jobs) as pool:
        seeds = [10_000 * seed + number for number in range(len(wanted))]
        made = pool.map(make, [folder / name for name in names], wanted, seeds)
        for number, (name, label) in enumerate(zip(names, made, strict=True)):
            labels[name] = label
            tell(number + 1, len(wanted))
    return labels


def sealed(labels: dict[str, Any], path: Path) -> str:
    """Write labels apart from the recordings; return their SHA-256, known before any tool runs."""
    text = json.dumps(labels, indent=1, sort_keys=True)
    path.write_text(text, encoding="utf-8")
    return hashlib.sha256(text.encode()).hexdigest()


def asked(
    ask: Callable[[Question], Answer],
    questions: Mapping[str, Question],
    jobs: int,
    tell: Callable[[int, int], None],
) -> dict[str, Answer]:
    """Return the answers to questions, by name.

    Args:
        ask: what is asked, as a folder of recordings and a tool, to its JSON answer.
        questions: by name.
        jobs: processes.
        tell: is told how many are done, of how many.
    """
    answers = {}
    with ProcessPoolExecutor(jobs) as pool:
        given = pool.map(ask, questions.values())
        for number, (name, answer) in enumerate(zip(questions, given, strict=True)):
            answers[name] = answer
            tell(number + 1, len(questions))
    return answers
