"""Runs of a tool over a corpus, case by case in several processes, with answers that survive a stop."""

from __future__ import annotations

import hashlib
import json
import random
from concurrent.futures import ProcessPoolExecutor
from typing import TYPE_CHECKING, Any, TypeVar

from threadpoolctl import threadpool_limits

from omnimate.proof.cases import cases, seed_of
from omnimate.proof.corpus import make

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from pathlib import Path

Answer = dict[str, Any]
Question = TypeVar("Question")
Reply = TypeVar("Reply")


def write_corpus(
    folder: Path, jobs: int, report: Callable[[int, int], None], *, quick: bool, seed: int, part: float = 1.0
) -> dict[str, Any]:
    """Write the corpus of the independent engine into a folder; return its labels.

    Args:
        folder: Folder of the corpus, which must not exist yet.
        jobs: Number of processes.
        report: Function that is called with the number of cases done and the number of all cases.
        quick: Whether to write the small corpus.
        seed: Seed of all random draws.
        part: Share of the cases to write, drawn at random.
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
        for case_folder, label in zip(folders, made, strict=True):
            labels[case_folder.name] = label
            report(len(labels), count)
    return labels


def _pool(jobs: int) -> ProcessPoolExecutor:
    """Return a pool of processes that use one thread each for matrices, as all cores are busy already."""
    return ProcessPoolExecutor(jobs, initializer=threadpool_limits, initargs=(1,))


def seal(labels: dict[str, Any], path: Path) -> str:
    """Write labels to a file and return its SHA-256, so that both are known before any tool runs."""
    text = json.dumps(labels, indent=1, sort_keys=True)
    path.write_text(text, encoding="utf-8")
    return hashlib.sha256(text.encode()).hexdigest()


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
