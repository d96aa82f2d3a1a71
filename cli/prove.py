"""`omnimate prove`: conceal effects in recordings, ask the mismatch tool, and print how often it is right."""

from __future__ import annotations

import json
import tempfile
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from cli import proving
from cli.console import out
from cli.prove_real import show_real
from cli.prove_tables import compared, instead, missed, redriven, shown
from cli.proving import Corpus, ask, ask_all, ask_engine, ask_without, telling
from vehicle.errors import OmnimateError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from cli.proving import Answers, Tool

EASE = {"mujoco": 0.9}  # of the targets, by folder: no law of the library is exact there
TITLES = {"own": "independent engine", "mujoco": "contact physics (MuJoCo)"}  # by folder


def prove(
    quick: Annotated[
        bool, typer.Option("--quick", help="A small part of the corpus, as CI runs it.")
    ] = False,
    contact: Annotated[
        bool,
        typer.Option("--contact/--no-contact", help="Also the robot in MuJoCo, where that is installed."),
    ] = True,
    folder: Annotated[
        Path | None,
        typer.Option(
            "--out", help="Keep recordings, labels and answers here; a run that was stopped goes on."
        ),
    ] = None,
    real: Annotated[
        Path, typer.Option(help="Folder of real recordings; its part is left out where it is absent.")
    ] = Path("../shared/data/real"),
    real_only: Annotated[bool, typer.Option("--real-only", help="Only the real recordings.")] = False,
    figures: Annotated[
        Path | None, typer.Option(help="Folder for figures of the real recordings.", exists=True)
    ] = None,
    jobs: Annotated[int, typer.Option(help="Processes.", min=1)] = 2,
    seed: Annotated[int, typer.Option(help="Of the corpus.", min=0)] = 1,
    part: Annotated[
        float,
        typer.Option(help="Share of the independent engine's cases, drawn by chance.", min=0.001, max=1.0),
    ] = 1.0,
    baselines: Annotated[
        bool | None,
        typer.Option("--baselines/--no-baselines", help="Also plain methods; with --quick on a few cases."),
    ] = None,
    ablations: Annotated[
        bool | None,
        typer.Option("--ablations/--no-ablations", help="Also the tool without each of its parts; likewise."),
    ] = None,
    leave_one_out: Annotated[
        bool | None,
        typer.Option(
            "--leave-one-out/--no-leave-one-out",
            help="Also the tool without the effect that is concealed; likewise.",
        ),
    ] = None,
) -> None:
    """Prove the mismatch tool on recordings in which engines that share no code with it conceal effects."""
    if real_only:
        show_real(real, figures)
        return
    with tempfile.TemporaryDirectory() if folder is None else nullcontext(str(folder)) as place:
        corpora = _corpora(Path(place), jobs, quick=quick, contact=contact, seed=seed, part=part)
        answers = _prove(Path(place), corpora, jobs)
        for one in corpora:
            if one.folder.name == "own":
                audits = ask_engine(one, answers, jobs, quick=quick, seed=seed)
                out.print(redriven(one.title, audits))
        for wanted, show in (
            (baselines, partial(_compare, "Baselines", proving.baselines(), answers)),
            (ablations, partial(_compare, "Ablations", proving.ablations(), answers)),
            (leave_one_out, _leave_one_out),
        ):
            for corpus in _portion(corpora, quick=quick, wanted=wanted):
                show(corpus, Path(place), jobs)
    if not quick:
        show_real(real, figures)


def _corpora(place: Path, jobs: int, *, quick: bool, contact: bool, seed: int, part: float) -> list[Corpus]:
    """Write the corpora; print what seals their labels before any tool runs."""
    from proof.run import sealed, write_corpus

    asked_for = json.dumps({"quick": quick, "contact": contact, "seed": seed, "part": part})
    wish = place / "corpus.json"
    if wish.exists():
        return _corpora_kept(place, wish.read_text(encoding="utf-8"), asked_for)
    if (place / "own").exists():
        raise OmnimateError(
            f"{place / 'own'} is of a corpus that was not finished: remove it, or take another --out"
        )
    with telling("concealing effects") as tell:
        labels = write_corpus(place / "own", jobs, tell, quick=quick, seed=seed, part=part)
    corpora = [Corpus(TITLES["own"], labels, place / "own")]
    bodies = _contact(place / "mujoco", quick=quick, seed=seed) if contact else {}
    if bodies:
        corpora.append(Corpus(TITLES["mujoco"], bodies, place / "mujoco"))
    for one in corpora:
        seal = sealed(dict(one.labels), one.folder.with_suffix(".json"))
        out.print(f"labels of the {one.title}: {len(one.labels)}, SHA-256 {seal}")
    wish.write_text(asked_for, encoding="utf-8")
    return corpora


def _corpora_kept(place: Path, known: str, wanted: str) -> list[Corpus]:
    """Return the corpora of a run that was stopped, to go on with it.

    Raises:
        OmnimateError: it was asked for another corpus.
    """
    if known != wanted:
        raise OmnimateError(
            f"{place} holds the corpus {known}; {wanted} needs a folder of its own: --out FOLDER"
        )
    return [
        Corpus(title, json.loads(labels.read_text(encoding="utf-8")), place / name)
        for name, title in TITLES.items()
        if (labels := place / f"{name}.json").exists()
    ]


def _prove(place: Path, corpora: Sequence[Corpus], jobs: int) -> Answers:
    """Print how often the tool is right; return its answers to all cases."""
    from mismatch import diagnose

    cases = {name: (one.folder / name, diagnose) for one in corpora for name in one.labels}
    answers = ask("diagnosing", cases, jobs, place / "answers.jsonl")
    (place / "answers.json").write_text(json.dumps(answers), encoding="utf-8")
    refused = [
        f"{name}: {answer['says']}" for name, answer in answers.items() if answer["verdict"] == "error"
    ]
    if refused:
        out.print(
            f"{len(refused)} of {len(answers)} cases were refused as bad input; the first: {refused[0]}"
        )
    for one in corpora:
        out.print(shown(one.title, one.labels, answers, EASE.get(one.folder.name, 1.0)))
        out.print(instead(one.title, one.labels, answers))
    return answers


def _portion(corpora: Sequence[Corpus], *, quick: bool, wanted: bool | None) -> Sequence[Corpus]:
    """Return what to ask more about: everything, nothing, or a few cases where little time is to be spent."""
    if wanted is None and quick:
        return [corpora[0].few()]
    return [] if wanted is False else corpora


def _compare(
    title: str, tools: Mapping[str, Tool], known: Answers, corpus: Corpus, place: Path, jobs: int
) -> None:
    """Print what other tools' answers are worth beside the tool's own."""
    found = ask_all(title.lower(), corpus, tools, jobs)
    path = place / f"{title.lower()}-{corpus.folder.name}.json"
    path.write_text(json.dumps(found), encoding="utf-8")
    ease = EASE.get(corpus.folder.name, 1.0)
    out.print(compared(f"{title}: {corpus.title}", corpus.labels, {"diagnose": known, **found}, ease))


def _leave_one_out(corpus: Corpus, place: Path, jobs: int) -> None:
    """Print what the tool answers where what is concealed has no name."""
    found = ask_without(corpus, jobs)
    path = place / f"leave-one-out-{corpus.folder.name}.json"
    path.write_text(json.dumps(found), encoding="utf-8")
    out.print(missed(f"Leave one out: {corpus.title}", corpus.labels, found))


def _contact(folder: Path, *, quick: bool, seed: int) -> dict[str, Any]:
    try:
        from proof.mujoco_corpus import corpus, write
    except ImportError:
        out.print(
            "MuJoCo is not installed (pip install 'omnimate[mujoco]'): its part of the corpus is left out"
        )
        return {}
    write(folder, corpus(6 if quick else 46), seed)
    return dict(json.loads((folder / "labels.json").read_text(encoding="utf-8")))
