"""Asking the mismatch tool, parts of it and plainer ones about a corpus, with a progress bar."""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

from rich.progress import Progress

from cli.console import err
from vehicle.errors import OmnimateError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence
    from pathlib import Path

    from mismatch import Diagnosis
    from proof.audit import Audit
    from vehicle.recording import Recording

    Tool = Callable[[Sequence[Recording]], Diagnosis]
    Answers = Mapping[str, dict[str, Any]]

FEW = ("null", "single", "unknown")  # kinds of which one case each is a few


@dataclass(frozen=True, slots=True)
class Corpus:
    """Recordings of one engine.

    Attributes:
        title: of the engine.
        labels: of each case.
        folder: that holds a folder of recordings for each case.
    """

    title: str
    labels: Mapping[str, Any]
    folder: Path

    def few(self) -> Corpus:
        """Return one case of each of three kinds."""
        first = {label["kind"]: name for name, label in reversed(list(self.labels.items()))}
        return replace(self, labels={first[kind]: self.labels[first[kind]] for kind in FEW if kind in first})


@contextmanager
def telling(doing: str) -> Iterator[Callable[[int, int], None]]:
    """Show a progress bar; give what tells it how much is done, of how much."""
    with Progress(console=err, transient=True) as progress:
        task = progress.add_task(doing, total=None)
        yield lambda done, total: progress.update(task, completed=done, total=total)


def answered(question: tuple[Path, Tool]) -> dict[str, Any]:
    """Return a tool's answer to all recordings of a case."""
    from vehicle.folder import load_recording

    folder, tool = question
    try:
        return tool([load_recording(one) for one in sorted(folder.iterdir()) if one.is_dir()]).as_json()
    except OmnimateError as error:
        return {"verdict": "error", "says": str(error), "findings": [], "fit": None}


def ask(
    doing: str, questions: Mapping[str, tuple[Path, Tool]], jobs: int, kept: Path | None = None
) -> dict[str, dict[str, Any]]:
    """Return the answers to questions, each a folder of recordings and a tool, by name."""
    from proof.run import asked

    with telling(doing) as tell:
        return asked(answered, questions, jobs, tell, kept)


def ask_engine(corpus: Corpus, answers: Answers, jobs: int, *, quick: bool, seed: int) -> list[Audit]:
    """Return what the engine says of names that were told in the truth's place, when it drives them."""
    from proof.audit import audited, questions
    from proof.cases import cases
    from proof.run import asked

    waiting = {one.name: one for one in questions(corpus.labels, answers, cases(quick), seed)}
    if not waiting:
        return []
    with telling("driving what was told") as tell:
        return list(asked(audited, waiting, jobs, tell).values())


def ask_all(doing: str, corpus: Corpus, tools: Mapping[str, Tool], jobs: int) -> dict[str, Answers]:
    """Return the answers of tools to all cases of a corpus, by tool and case."""
    pairs = [(name, case) for name in tools for case in corpus.labels]
    answers = ask(
        doing, {f"{name} {case}": (corpus.folder / case, tools[name]) for name, case in pairs}, jobs
    )
    return {name: {case: answers[f"{name} {case}"] for case in corpus.labels} for name in tools}


def ask_without(corpus: Corpus, jobs: int) -> dict[str, dict[str, Any]]:
    """Return what the tool answers to each case without the effect that is concealed in it."""
    from mismatch import diagnose
    from proof.leave_one_out import concealing

    questions = {
        case: (corpus.folder / case, partial(diagnose, without=(effect,)))
        for case, effect in concealing(corpus.labels).items()
    }
    return ask("leaving out what is concealed", questions, jobs)


def baselines() -> dict[str, Tool]:
    """Return the plain methods."""
    from mismatch.baselines import baseline
    from mismatch.sparse import METHODS

    return {name: partial(baseline, name=name) for name in METHODS}


def ablations() -> dict[str, Tool]:
    """Return the tool without each of its parts."""
    from mismatch import diagnose
    from mismatch.parts import ABLATIONS

    return {name: partial(diagnose, parts=parts) for name, parts in ABLATIONS.items()}
