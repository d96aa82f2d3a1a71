"""The corpora of a study: written into a folder, their labels sealed, and taken up again after a stop."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, replace
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, NamedTuple

from omnimate.proof import run
from omnimate.vehicle.errors import OmnimateError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

    from omnimate.evaluation.progress import Progress

FEW = ("null", "single", "unknown")  # the kinds of which a few cases hold one each


class Engine(NamedTuple):
    """An engine that conceals effects.

    Attributes:
        title: What its tables call it.
        ease: Factor on the targets.
    """

    title: str
    ease: float


ENGINES = {
    "own": Engine("independent engine", 1.0),
    "mujoco": Engine("contact physics (MuJoCo)", 0.9),  # no law of the library is exact there
}  # by the name of the corpus's folder


@dataclass(frozen=True, slots=True)
class Request:
    """Which corpora a study is about.

    Attributes:
        quick: Whether a small part is enough, as CI runs it.
        contact: Whether the robot in MuJoCo is part of it, where that is installed.
        seed: Seed of everything that is drawn by chance.
        part: Share of the independent engine's cases, drawn by chance.
    """

    quick: bool
    contact: bool
    seed: int
    part: float


@dataclass(frozen=True, slots=True)
class Corpus:
    """Recordings of one engine.

    Attributes:
        labels: The label of each case, by its name.
        folder: Holds a folder of recordings for each case.
    """

    labels: Mapping[str, Any]
    folder: Path

    @property
    def name(self) -> str:
        """Name of the engine, a key of `ENGINES`."""
        return self.folder.name

    @property
    def title(self) -> str:
        """What tables call the engine."""
        return ENGINES[self.name].title

    @property
    def ease(self) -> float:
        """Factor on the targets."""
        return ENGINES[self.name].ease

    def few(self) -> Corpus:
        """Return one case of each of three kinds."""
        first = {label["kind"]: name for name, label in reversed(list(self.labels.items()))}
        return replace(self, labels={first[kind]: self.labels[first[kind]] for kind in FEW if kind in first})


def write_corpora(place: Path, request: Request, jobs: int, progress: Progress) -> Iterator[Corpus]:
    """Write the corpora of a request into a folder, and yield each; or those that the folder holds already.

    Raises:
        OmnimateError: The folder holds another corpus, or one that was not finished.
    """
    known, wanted = place / "corpus.json", json.dumps(asdict(request))
    if known.exists():
        yield from _kept(place, known.read_text(encoding="utf-8"), wanted)
        return
    folder = place / "own"
    if folder.exists():
        raise OmnimateError(
            f"{folder} is of a corpus that was not finished: remove it, or take another --out"
        )
    with progress("concealing effects") as report:
        labels = run.write_corpus(
            folder, jobs, report, quick=request.quick, seed=request.seed, part=request.part
        )
    yield Corpus(labels, folder)
    if request.contact and has_contact_engine():
        yield _contact(place / "mujoco", request)
    known.write_text(wanted, encoding="utf-8")


def seal(corpus: Corpus) -> str:
    """Write the labels of a corpus beside it; return their SHA-256, known before any tool runs."""
    return run.seal(dict(corpus.labels), corpus.folder.with_suffix(".json"))


def _kept(place: Path, known: str, wanted: str) -> Iterator[Corpus]:
    """Yield the corpora of a study that was stopped."""
    if known != wanted:
        raise OmnimateError(
            f"{place} holds the corpus {known}; {wanted} needs a folder of its own: --out FOLDER"
        )
    for name in ENGINES:
        labels = place / f"{name}.json"
        if labels.exists():
            yield Corpus(json.loads(labels.read_text(encoding="utf-8")), place / name)


def has_contact_engine() -> bool:
    """Return whether MuJoCo is installed."""
    return find_spec("mujoco") is not None


def _contact(folder: Path, request: Request) -> Corpus:
    """Write the corpus of the robot in MuJoCo."""
    from omnimate.proof.mujoco.corpus import corpus, write  # noqa: PLC0415  # MuJoCo may not be installed

    write(folder, corpus(6 if request.quick else 46), request.seed)
    return Corpus(json.loads((folder / "labels.json").read_text(encoding="utf-8")), folder)
