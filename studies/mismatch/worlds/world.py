"""What a world is: a name, and labelled cases that any tool can be asked about."""

from __future__ import annotations

import hashlib
import json
import random
import shutil
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from omnimate.vehicle.errors import OmnimateError
from studies.mismatch import run
from studies.mismatch.run import Answer, Progress, Question, Report, answered

Label = dict[str, Any]
Reply = TypeVar("Reply")
FEW = 3  # cases of a labelled set, where a small part is enough


class AbsentError(OmnimateError):
    """A world that is not here: its data, or the engine that makes them."""


@dataclass(frozen=True, slots=True)
class Request:
    """How much of a world is asked for."""

    seed: int = 1  # seed of everything that is drawn by chance
    # number of cases, drawn by chance where the world has more; None for all that it has
    cases: int | None = None
    quick: bool = False  # whether a small part is enough, as CI runs it
    healthy: bool = False  # whether only robots without a fault are asked for


@dataclass(frozen=True, slots=True)
class Corpus:
    """Labelled recordings of one world."""

    world: World  # the world
    folder: Path  # holds a folder for each case, in which its recordings are
    # the label of each case, by its name; `recordings` in it names the recordings' folders
    labels: Mapping[str, Label]

    @property
    def digest(self) -> str:
        """SHA-256 of the labels, known before any tool runs."""
        return hashlib.sha256(_text(self.labels).encode()).hexdigest()

    def question(self, case: str) -> Question:
        """Return what is asked about a case: its folder and its label."""
        return self.folder / case, self.labels[case]


@dataclass(frozen=True, slots=True)
class World:
    """Where recordings with a known truth come from."""

    name: str  # name by which the world is asked for
    title: str  # what tables call it
    # whether others than the project made it; the pooled column counts those
    foreign: bool = field(default=False, kw_only=True)
    # answers the question about one case
    ask: Callable[[Question], Answer] = field(default=answered, kw_only=True)

    def corpus(self, place: Path, request: Request, jobs: int, progress: Progress) -> Corpus:
        """Return the cases of a request.

        AbsentError: the world is not here; OmnimateError: the folder holds another corpus of it.
        """
        raise NotImplementedError


@dataclass(frozen=True, slots=True)
class LabelledWorld(World):
    """Recordings that are there already, with a `labels.json` beside them."""

    folder: Path  # folder of both

    def corpus(self, place: Path, request: Request, jobs: int, progress: Progress) -> Corpus:  # noqa: ARG002
        """Return what is there, or a sample of it by the seed."""
        path = self.folder / "labels.json"
        if not path.exists():
            raise AbsentError(f"{self.folder} is not there: {self.name} is left out")
        if request.quick and request.cases is None:
            request = replace(request, cases=FEW)
        labels = json.loads(path.read_text(encoding="utf-8"))
        asked = {
            name: label for name, label in labels.items() if not request.healthy or label["kind"] == "null"
        }
        return Corpus(self, self.folder, drawn(asked, request))


@dataclass(frozen=True, slots=True)
class WrittenWorld(World):
    """Recordings that are made for the study."""

    # writes the cases of a request into a folder, each a folder with recordings; returns labels. It goes on
    # where it was stopped, and raises AbsentError where something that it needs is not here
    write: Callable[[Path, Request, int, Report], Mapping[str, Label]]

    def corpus(self, place: Path, request: Request, jobs: int, progress: Progress) -> Corpus:
        """Return what was written, now or before a stop."""
        folder, kept = place / self.name, place / f"{self.name}.json"
        wanted = asdict(request)
        if kept.exists():
            known = json.loads(kept.read_text(encoding="utf-8"))
            if (other := known["request"]) != wanted:
                raise OmnimateError(
                    f"{folder} holds the cases of {other}; {wanted} needs a folder of its own: --out"
                )
            if "labels" in known:
                return Corpus(self, folder, known["labels"])
        place.mkdir(parents=True, exist_ok=True)
        kept.write_text(json.dumps({"request": wanted}), encoding="utf-8")
        with progress(f"{self.name}: recordings") as report:
            try:
                labels = self.write(folder, request, jobs, report)
            except AbsentError:
                kept.unlink()
                raise
        kept.write_text(_text({"request": wanted, "labels": labels}), encoding="utf-8")
        return Corpus(self, folder, labels)


def write_all(
    write: Callable[..., Reply],
    wanted: Mapping[str, tuple[Any, ...]],
    folder: Path,
    jobs: int,
    report: Report,
) -> dict[str, Reply]:
    """Return the labels of cases, by name; what was written before a stop is not written again.

    `wanted` holds the arguments of `write` for each case, after the case's folder.
    """
    folder.mkdir(parents=True, exist_ok=True)
    placed = {name: (folder / name, *arguments) for name, arguments in wanted.items()}
    return run.ask_all(partial(_write_anew, write), placed, jobs, report, folder / "labels.jsonl")


def _write_anew(write: Callable[..., Reply], wanted: tuple[Any, ...]) -> Reply:
    """Write a case over what an earlier run left unfinished."""
    shutil.rmtree(wanted[0], ignore_errors=True)
    return write(*wanted)


def drawn(cases: Mapping[str, Reply], request: Request) -> dict[str, Reply]:
    """Return as many of the cases, by name, as are asked for, in their order."""
    count = len(cases) if request.cases is None else min(request.cases, len(cases))
    names = set(random.Random(request.seed).sample(sorted(cases), count))  # no secret
    return {name: case for name, case in cases.items() if name in names}


def _text(content: object) -> str:
    return json.dumps(content, indent=1, sort_keys=True)
