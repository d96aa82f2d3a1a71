"""`omnimate prove`: conceal effects in recordings, ask the mismatch tool, and print how often it is right."""

from __future__ import annotations

import json
import math
import tempfile
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.progress import Progress
from rich.table import Table

from cli.console import err, out
from vehicle.errors import OmnimateError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from proof.score import Row


def prove(
    quick: Annotated[
        bool, typer.Option("--quick", help="A small part of the corpus, as CI runs it.")
    ] = False,
    contact: Annotated[
        bool,
        typer.Option("--contact/--no-contact", help="Also the robot in MuJoCo, where that is installed."),
    ] = True,
    folder: Annotated[
        Path | None, typer.Option("--out", help="Keep recordings, labels and answers here.")
    ] = None,
    real: Annotated[
        Path, typer.Option(help="Folder of real recordings; its part is left out where it is absent.")
    ] = Path("../shared/data/real"),
    jobs: Annotated[int, typer.Option(help="Processes.", min=1)] = 2,
    seed: Annotated[int, typer.Option(help="Of the corpus.", min=0)] = 1,
) -> None:
    """Prove the mismatch tool on recordings in which engines that share no code with it conceal effects."""
    with tempfile.TemporaryDirectory() if folder is None else nullcontext(str(folder)) as place:
        _prove(Path(place), jobs, quick=quick, contact=contact, seed=seed)
    if not quick:
        _real(real)


def _prove(place: Path, jobs: int, *, quick: bool, contact: bool, seed: int) -> None:
    from proof.run import asked, sealed, write_corpus

    with Progress(console=err, transient=True) as progress:
        task = progress.add_task("concealing effects", total=None)

        def tell(done: int, total: int) -> None:
            progress.update(task, completed=done, total=total)

        labels = write_corpus(place / "own", jobs, tell, quick=quick, seed=seed)
        folders = {name: place / "own" / name for name in labels}
        out.print(
            f"labels of the independent engine: {len(labels)}, SHA-256 {sealed(labels, place / 'own.json')}"
        )
        bodies = _contact(place / "mujoco", quick=quick, seed=seed) if contact else {}
        if bodies:
            folders |= {name: place / "mujoco" / name for name in bodies}
            out.print(f"labels of MuJoCo: {len(bodies)}, SHA-256 {sealed(bodies, place / 'mujoco.json')}")
        progress.update(task, description="diagnosing")
        answers = asked(_ask, folders, jobs, tell)
    (place / "answers.json").write_text(json.dumps(answers), encoding="utf-8")
    _show("independent engine", labels, answers)
    if bodies:
        _show("contact physics (MuJoCo)", bodies, answers)


def _real(folder: Path) -> None:
    """Print what the tool finds in recordings of real robots, where nobody knows the truth."""
    from imports.optiodom import differential_sets, recordings_of
    from mismatch import diagnose

    if not (folder / "optiodom").is_dir():
        out.print(f"{folder / 'optiodom'} is not there: the real recordings are left out")
        return
    table = Table(title="OptiOdom: the nominal robot against its recordings, every set on its own")
    for heading in ("set", "held-out residual", "position, 10 s open loop", "first findings"):
        table.add_column(heading)
    sets, _ = differential_sets(folder / "optiodom")
    with Progress(console=err, transient=True) as progress:
        for one in progress.track(sets, description="real recordings"):
            diagnosis = diagnose(recordings_of(one))
            fit = diagnosis.fit
            assert fit is not None  # every set has poses and minutes of driving
            found = [
                f"{own.effect} {own.component} ({own.probability:.0%})" for own in diagnosis.findings[:3]
            ]
            loop = fit.rerun.get("a position")
            table.add_row(
                f"{one.parent.name}/{one.name}",
                f"{fit.heldout.before:.2f} -> {fit.heldout.after:.2f}",
                "-" if loop is None else f"{1e3 * loop.before:.1f} -> {1e3 * loop.after:.1f} mm",
                ", ".join(found) or diagnosis.verdict,
            )
    out.print(table)


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


def _ask(folder: Path) -> dict[str, Any]:
    """Return the tool's answer to all recordings of a case."""
    from mismatch import diagnose
    from vehicle.folder import load_recording

    try:
        recordings = [load_recording(one) for one in sorted(folder.iterdir()) if one.is_dir()]
        return diagnose(recordings).as_json()
    except OmnimateError as error:
        return {"verdict": "error", "says": str(error), "findings": [], "fit": None}


def _show(title: str, labels: Mapping[str, Any], answers: Mapping[str, Any]) -> None:
    from proof.score import rows

    table = Table(title=title)
    for heading, justify in (
        ("what", "left"),
        ("share", "right"),
        ("95 %", "right"),
        ("of", "right"),
        ("target", "right"),
        ("", "left"),
    ):
        table.add_column(heading, justify=justify)  # type: ignore[arg-type]
    for row in rows(labels, answers):
        table.add_row(*_cells(row), style="" if row.verdict != "NOT REACHED" else "bold")
    out.print(table)


def _cells(row: Row) -> tuple[str, ...]:
    if math.isnan(row.share):
        return row.name, "-", "", "0", "", row.note
    low, high = row.interval
    target = "" if row.target is None else f"{'<=' if row.most else '>='} {row.target:.2f}"
    return (
        row.name,
        f"{row.share:.3f}",
        f"{low:.2f}-{high:.2f}",
        str(row.of),
        target,
        f"{row.verdict} {row.note}".strip(),
    )
