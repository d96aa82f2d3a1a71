"""`omnimate diagnose`: where simulation and recording differ, which physics is missing, how sure that is."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from omnimate.cli.console import out, progress_bar, report_problem, say
from omnimate.cli.errors import CallError
from omnimate.cli.options import written_at_end
from omnimate.cli.tables import new_table, show
from omnimate.vehicle.errors import OmnimateError

if TYPE_CHECKING:
    from omnimate.mismatch import Diagnosis
    from omnimate.mismatch.diagnosis import Fit, Parameter
    from omnimate.vehicle.recording import Recording


def diagnose(
    recordings: Annotated[
        list[Path],
        typer.Argument(exists=True, help="Recording folders of one robot: laps of one or several."),
    ],
    json_out: Annotated[Path | None, written_at_end("File for the answer as JSON.", "--json")] = None,
    report: Annotated[Path | None, written_at_end("File for the report as HTML.")] = None,
    effects_out: Annotated[
        Path | None, written_at_end("File for the effects found, which `omnimate simulate --effects` loads.")
    ] = None,
    each: Annotated[
        bool,
        typer.Option("--each", help="Diagnose each folder alone; write the answers next to the folders."),
    ] = False,
    jobs: Annotated[int, typer.Option(help="Processes, with --each.", min=1)] = 1,
    triage: Annotated[
        bool,
        typer.Option("--triage", help="Only test, in 0.3 s, whether there is a mismatch, and where."),
    ] = False,
    budget: Annotated[
        float | None,
        typer.Option(help="Processor time [s] of the search; 20 s for 20,000 samples.", min=0.0),
    ] = None,
) -> None:
    """Compare recordings with a simulation: where they differ, which physics is missing."""
    if triage and (report or effects_out):
        raise CallError("--triage names no effects; leave out --report and --effects-out")
    if each:
        if json_out or report or effects_out:
            raise CallError(
                "--each writes <folder>.json and <folder>.html next to every recording; "
                "leave out --json, --report and --effects-out"
            )
        _each(recordings, jobs, triage=triage)
        return
    if jobs > 1:
        raise CallError("--jobs shares recordings of several robots among processes; add --each")
    from omnimate.cli.loading import load

    loaded = [load(folder) for folder in recordings]
    if triage:
        _triage(loaded, json_out)
        return
    from omnimate.mismatch import diagnose as ask

    with progress_bar("reading") as progress:
        diagnosis = ask(loaded, progress=progress, budget=budget)
    try:
        _write(diagnosis, json_out, report, effects_out)
    finally:  # a full disk costs the files, not the answer
        _show(diagnosis)


def _triage(recordings: Sequence[Recording], json_out: Path | None) -> None:
    """Print, and write, whether there is a mismatch at all."""
    from omnimate.mismatch.triage import triage as ask

    answer = ask(recordings)
    try:
        if json_out is not None:
            _write_json(json_out, answer.as_json())
    finally:
        out.print(f"{answer.verdict}: {answer.says}", style="bold")


def _write_json(path: Path, content: object) -> None:
    from omnimate.vehicle.atomic import write_text

    write_text(path, json.dumps(content, indent=2) + "\n")


def _write(
    diagnosis: Diagnosis, json_out: Path | None, report: Path | None, effects_out: Path | None
) -> None:
    from omnimate.vehicle.atomic import write_text

    if json_out is not None:
        _write_json(json_out, diagnosis.as_json())
    if report is not None:
        from omnimate.mismatch.report.page import render

        write_text(report, render(diagnosis))
    if effects_out is not None:
        from omnimate.effects.file import save_effects

        save_effects(effects_out, diagnosis.effects)


def _diagnose_folder(folder: Path, *, triage: bool) -> tuple[str | None, list[str]]:
    """Diagnose a folder, or triage it, in a separate process; return one line of answer, and the problems."""
    from omnimate.cli.loading import first_problems
    from omnimate.files.recordings.folder import read_recording
    from omnimate.mismatch import Diagnosis
    from omnimate.mismatch import diagnose as ask
    from omnimate.mismatch.triage import triage as ask_triage

    line: str | None = None
    problems: list[str] = []
    try:
        loaded = read_recording(folder)
        problems += first_problems(loaded.log.blocks)
        recordings = [loaded.recording]
        answer = ask_triage(recordings) if triage else ask(recordings)
        line = f"{answer.verdict}: {answer.says}"
        answer_path = os.path.abspath(folder)  # noqa: PTH100  # `.` has no name, and a link keeps its own
        if isinstance(answer, Diagnosis):
            _write(answer, Path(f"{answer_path}.json"), Path(f"{answer_path}.html"), None)
        else:
            _write_json(Path(f"{answer_path}.triage.json"), answer.as_json())
    except OmnimateError as error:
        problems.append(f"{folder}: {error}")
    except MemoryError:
        problems.append(f"{folder}: it takes more memory than there is")
    except OSError as error:
        problems.append(f"{error.filename or folder}: {error.strerror or error}")
    return line, problems


def _each(folders: Sequence[Path], jobs: int, *, triage: bool) -> None:
    """Diagnose folders in separate processes."""
    with progress_bar("diagnosing") as progress, ProcessPoolExecutor(jobs) as pool:
        answers = pool.map(partial(_diagnose_folder, triage=triage), folders)
        for done, (folder, (line, problems)) in enumerate(zip(folders, answers, strict=True), start=1):
            progress(done, len(folders))
            if line is not None:
                say(f"{folder}: {line}")
            for problem in problems:
                report_problem(problem)


def _show(diagnosis: Diagnosis) -> None:
    """Print the diagnosis."""
    out.print(f"{diagnosis.verdict}: {diagnosis.says}", style="bold")
    for finding in diagnosis.findings:
        out.print()
        say(f"{finding.probability:5.0%}  {finding.effect} on {finding.component}: {finding.says}")
        for parameter in finding.parameters:
            out.print(f"       {shown(parameter)}")
        if finding.repeats is not None:
            same = "they agree" if finding.repeats.agree else "they differ"
            say(f"       by each recording alone: {shown(finding.repeats.parameter)}: {same}")
        for other in finding.alternatives:
            out.print(f"       or {other.effect} on {other.component} ({other.probability:.0%})")
        if finding.separates:
            say(f"       to distinguish them, drive: {finding.separates}")
    for trace in diagnosis.traces:
        say(f"trace, {trace.probability:.0%}: {trace.effect} on {trace.component}: {trace.says}")
    if diagnosis.calibrated:
        out.print("\ncalibrated from the recorded poses, not a finding:")
    for effect in diagnosis.calibrated:
        out.print(f"       {effect.effect} on {effect.component}: {', '.join(map(shown, effect.parameters))}")
    if diagnosis.fit is not None:
        _show_fit(diagnosis.fit)


def _show_fit(fit: Fit) -> None:
    """Print the residuals, and levels of noise that are not usual."""
    title = "residual on data that no fit has seen (1.00 = the noise that is expected)"
    changes = {**fit.channels, "all": fit.heldout}
    rows = [(name, f"{change.before:.2f}", f"{change.after:.2f}") for name, change in changes.items()]
    out.print()
    show(new_table(title, ("channel",), ("before", "after"), rows))
    for level in fit.unusual_noise:
        say(f"noise: {level}")


def shown(parameter: Parameter) -> str:
    """Return a parameter with its 95 % interval in millimetres, degrees or its own unit."""
    factor, unit = {"m": (1e3, "mm"), "rad": (math.degrees(1.0), "degrees"), "1": (1.0, "")}.get(
        parameter.unit, (1.0, parameter.unit)
    )
    values = parameter.value if isinstance(parameter.value, tuple) else (parameter.value,)
    sigmas = parameter.sigma if isinstance(parameter.sigma, tuple) else (parameter.sigma,)
    parts = [
        f"{_number(factor * value)} +- {1.96 * factor * sigma:.2g}"
        for value, sigma in zip(values[:8], sigmas[:8], strict=True)
    ]
    more = f" and {len(values) - 8} more" if len(values) > 8 else ""
    return f"{parameter.name} = {', '.join(parts)}{more} {unit}".rstrip()


def _number(value: float) -> str:
    """Return a number with six digits, or a time on a computer's clock with its milliseconds."""
    return f"{value:.3f}" if abs(value) >= 1e6 else f"{value:.6g}"
