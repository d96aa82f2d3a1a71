"""`omnimate prove`: conceal effects in recordings, ask the mismatch tool, and print how often it is right."""

from __future__ import annotations

import tempfile
from contextlib import nullcontext
from pathlib import Path
from typing import Annotated

import typer

from omnimate.cli.console import out, progress_bar
from omnimate.cli.studies import check_checkout


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
    jobs: Annotated[int, typer.Option(help="Processes that work at once.", min=1)] = 2,
    seed: Annotated[int, typer.Option(help="Seed of the corpus.", min=0)] = 1,
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
    check_checkout("prove", "evaluation")
    from omnimate.evaluation.corpora import Request
    from omnimate.evaluation.real import real_part
    from omnimate.evaluation.study import Comparisons, study

    if not real_only:
        request = Request(quick=quick, contact=contact, seed=seed, part=part)
        comparisons = Comparisons(baselines, ablations, leave_one_out)
        with tempfile.TemporaryDirectory() if folder is None else nullcontext(str(folder)) as place:
            for result in study(Path(place), request, comparisons, jobs, progress_bar):
                out.print(result, soft_wrap=isinstance(result, str))
    if real_only or not quick:
        for result in real_part(real, figures, progress_bar):
            out.print(result, soft_wrap=isinstance(result, str))
