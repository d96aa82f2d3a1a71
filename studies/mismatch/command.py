"""`python -m studies prove`: how often the mismatch tool is right on recordings of known truth."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable
from contextlib import nullcontext
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from omnimate.cli.console import progress_bar, say
from omnimate.cli.tables import show
from studies.mismatch.laws import study as of_laws
from studies.mismatch.real import real_part
from studies.mismatch.study import study
from studies.mismatch.worlds.registry import chosen
from studies.mismatch.worlds.world import Request


def prove(
    world: Annotated[
        list[str] | None,
        typer.Option(
            help="A world to ask about: engine, wide, mujoco, concealed, concealed2, contact, contact2, "
            "unnamed, bullet, injections or optiodom. "
            "All of them where none is named."
        ),
    ] = None,
    cases: Annotated[
        int | None,
        typer.Option(help="Cases of each world, drawn by chance where it has more.", min=1),
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="A small part of each world, as CI runs it.")
    ] = False,
    folder: Annotated[
        Path | None,
        typer.Option(
            "--out",
            help="Keep recordings, labels, answers and the table (proof.json) here; a run that was stopped "
            "goes on.",
        ),
    ] = None,
    data: Annotated[
        Path, typer.Option(help="Folder of labelled sets and real recordings; what is absent is left out.")
    ] = Path("../shared/data"),
    healthy: Annotated[
        bool, typer.Option("--healthy", help="Only robots without a fault: how often one is reported.")
    ] = False,
    real_only: Annotated[
        bool, typer.Option("--real-only", help="Only the two real robots that are described wrongly.")
    ] = False,
    laws: Annotated[
        bool,
        typer.Option("--laws", help="Only the laws that are learned where an effect is not in the library."),
    ] = False,
    figures: Annotated[
        Path | None,
        typer.Option(
            help="Folder for the reliability diagrams and the real recordings' figures.", exists=True
        ),
    ] = None,
    jobs: Annotated[int, typer.Option(help="Processes that work at once.", min=1)] = 2,
    seed: Annotated[int, typer.Option(help="Seed of everything that is drawn by chance.", min=0)] = 1,
    leave_one_out: Annotated[
        bool,
        typer.Option(
            "--leave-one-out", help="Also the tool without what is concealed, in the engine's world."
        ),
    ] = False,
) -> None:
    """Prove the mismatch tool on recordings of known truth, from many worlds that share no code with it."""
    with tempfile.TemporaryDirectory() if folder is None else nullcontext(str(folder)) as kept:
        place = Path(kept)
        if laws:
            count = cases or (1 if quick else of_laws.CASES)
            _show(of_laws.study(place, seed, jobs, progress_bar, figures, count=count, quick=quick))
        elif not real_only:
            asked, request = chosen(data, world or ()), Request(seed, cases, quick, healthy)
            _show(study(place, asked, request, jobs, progress_bar, figures, leave_one_out=leave_one_out))
    if real_only or not (laws or quick or world):
        _show(real_part(data / "real", figures))


def _show(results: Iterable[Table | str]) -> None:
    for result in results:
        say(result) if isinstance(result, str) else show(result)
