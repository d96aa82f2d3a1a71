"""`python -m studies prove`: how often the mismatch tool is right on recordings of known truth.

Worlds are made or found, the tool is asked about each, and what its answers are worth stands in one table.
"""

from __future__ import annotations

import json
import tempfile
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.table import Table
from rich.text import Text

from omnimate.cli.console import progress_bar, say
from omnimate.cli.tables import new_table, show
from omnimate.mismatch import diagnose
from studies.figures import plot_efficiency, plot_errors, plot_reliability
from studies.mismatch import run
from studies.mismatch.engines.scene import cases as engine_cases
from studies.mismatch.laws import study as of_laws
from studies.mismatch.real import real_part
from studies.mismatch.run import Answer, Answers, Progress, Tool, answered_by
from studies.mismatch.scoring.audit import Audit, audited, questions
from studies.mismatch.scoring.efficiency import efficiency
from studies.mismatch.scoring.judging import (
    OUTCOMES,
    beyond_twins,
    concealing,
    left_out_rows,
    reported_instead,
)
from studies.mismatch.scoring.score import Line, Score, pooled, scored
from studies.mismatch.worlds.registry import chosen
from studies.mismatch.worlds.world import AbsentError, Corpus, Request, World


def ask_tool(corpus: Corpus, jobs: int, progress: Progress, kept: Path | None = None) -> dict[str, Answer]:
    """Return the tool's answers to all cases of a corpus, by case; the file `kept` receives each at once."""
    wanted = {case: corpus.question(case) for case in corpus.labels}
    with progress(f"{corpus.world.name}: diagnosing") as report:
        answers = run.ask_all(corpus.world.ask, wanted, jobs, report, kept)
    return {case: answers[case] for case in wanted}


def ask_without(corpus: Corpus, jobs: int, progress: Progress) -> dict[str, Answer]:
    """Return what the tool answers to each case without the effect that is concealed in it."""
    wanted: dict[str, tuple[Tool, tuple[Path, dict[str, object]]]] = {
        case: (partial(diagnose, without=(effect,)), corpus.question(case))
        for case, effect in concealing(corpus.labels).items()
    }
    with progress(f"{corpus.world.name}: leaving out what is concealed") as report:
        return run.ask_all(answered_by, wanted, jobs, report)


def ask_engine(
    corpus: Corpus, answers: Answers, jobs: int, request: Request, progress: Progress
) -> list[Audit]:
    """Return how far the names reported in the truth's place lead when the engine drives them."""
    wanted = {
        question.name: question
        for question in questions(corpus.labels, answers, engine_cases(request.quick), request.seed)
    }
    if not wanted:
        return []
    with progress("driving what was reported") as report:
        return list(run.ask_all(audited, wanted, jobs, report).values())


ERRORS = ("nominal", "least squares", "found")  # the ways to predict what was not seen
RESULT, RELIABILITY = "proof.json", "reliability.png"


def study(
    place: Path,
    worlds: Sequence[World],
    request: Request,
    jobs: int,
    progress: Progress,
    figures: Path | None = None,
    *,
    leave_one_out: bool = False,
) -> Iterator[Table | str]:
    """Carry the study out in a folder, and yield its tables and sentences as they are known.

    OmnimateError: the folder holds another corpus; PlotError: a figure cannot be written.
    """
    place.mkdir(parents=True, exist_ok=True)
    scores: list[Score] = []
    asked: list[tuple[Corpus, Answers]] = []
    answers: Answers
    for world in worlds:
        try:
            corpus = world.corpus(place, request, jobs, progress)
        except AbsentError as absent:
            yield str(absent)
            continue
        yield f"labels of {world.name}: {len(corpus.labels)}, SHA-256 {corpus.digest}"
        answers = ask_tool(corpus, jobs, progress, place / f"{world.name}.answers.jsonl")
        yield from _refused(answers)
        scores.append(scored(corpus, answers))
        asked.append((corpus, answers))
    if not scores:
        return
    columns = [*scores, *pooled(asked)]
    _write(place / RESULT, {"worlds": {score.name: score.as_json() for score in columns}})
    yield worlds_table(columns)
    if figures is not None:
        _draw(scores, asked, figures)
    for corpus, answers in asked:
        if reported := reported_instead(corpus.labels, answers):
            yield instead_table(corpus.world.title, reported)
        if any("open_loop" in answer for answer in answers.values()):
            yield open_loop_table(corpus.world.title, corpus.labels, answers)
        if corpus.world.name == "engine":
            audits = ask_engine(corpus, answers, jobs, request, progress)
            yield redriven_table(corpus.world.title, audits)
            if leave_one_out:
                unnamed = ask_without(corpus, jobs, progress)
                _write(place / "leave-one-out.json", unnamed)
                yield missed_table("Leave one out", corpus.labels, unnamed)


def _draw(scores: Sequence[Score], asked: Sequence[tuple[Corpus, Answers]], figures: Path) -> None:
    plot_reliability({score.title: score.reliability for score in scores}, figures / RELIABILITY)
    for corpus, answers in asked:
        kinds = {label["kind"] for label in corpus.labels.values()}
        if "calibration" in kinds:
            _draw_open_loop(corpus, answers, figures / f"{corpus.world.name}.png")
        if "injected" in kinds:
            curve = efficiency(corpus.labels, beyond_twins(corpus.labels, answers))
            plot_efficiency(curve, figures / f"{corpus.world.name}.png", corpus.world.title)


def _draw_open_loop(corpus: Corpus, answers: Answers, path: Path) -> None:
    cases = [case for case in corpus.labels if "open_loop" in answers[case]]
    columns = {error: [answers[case]["open_loop"][error] for case in cases] for error in ERRORS}
    plot_errors(cases, columns, path)


def _refused(answers: Answers) -> Iterator[str]:
    """Yield how many cases were refused, or made the tool fail."""
    refused = [
        f"{name}: {answer['says']}" for name, answer in answers.items() if answer["verdict"] == "error"
    ]
    if refused:
        yield f"{len(refused)} of {len(answers)} cases were refused or failed; the first: {refused[0]}"


def _write(path: Path, content: object) -> None:
    path.write_text(json.dumps(content, indent=1), encoding="utf-8")


def worlds_table(scores: Sequence[Score]) -> Table:
    """Return the one table: a line for each figure, a column for each world, empty lines left out."""
    heads = [f"{score.title}\n{score.cases} cases" for score in scores]
    table = new_table("The mismatch tool in every world", ("what",), ("wanted", *heads))
    table.caption = "bold: the target is not reached"
    for lines in zip(*(score.lines for score in scores), strict=True):
        if any(line.text != "-" for line in lines):
            table.add_row(lines[0].name, _target(lines[0]), *map(_cell, lines))
    return table


def _cell(line: Line) -> Text:
    return Text(line.text, style="bold" if line.is_missed else "")


def open_loop_table(title: str, labels: Mapping[str, Any], answers: Answers) -> Table:
    """Return a table of position errors on recordings that were not seen, a row for each case."""
    what = f"{title}: position error on the other half after 10 s of open loop, rms [mm]"
    table = new_table(what, ("case",), ERRORS)
    table.add_column("first findings")
    for case in labels:
        errors = answers[case].get("open_loop")
        shown = ("-",) * len(ERRORS) if errors is None else [f"{1e3 * errors[error]:.1f}" for error in ERRORS]
        findings = [
            f"{finding['effect']} {finding['component']} {finding['probability']:.0%}"
            for finding in answers[case]["findings"][:3]
        ]
        table.add_row(case, *shown, "; ".join(findings) or answers[case]["verdict"])
    return table


def instead_table(title: str, reported: Counter[tuple[str, str]]) -> Table:
    """Return a table of the names that counted as right in the truth's place, for who judges otherwise."""
    what = f"{title}: counted as right, as the drive cannot tell them apart"
    rows = ((*names, str(count)) for names, count in reported.most_common())
    return new_table(what, ("truth", "reported first"), ("cases",), rows)


def redriven_table(title: str, audits: Sequence[Audit]) -> Table:
    """Return a table of what was reported in the truth's place, and how far off the engine drives it."""
    what = f"{title}: reported in the truth's place, driven by the engine itself"
    table = new_table(what, ("case", "truth", "reported", "counts as"), ("from healthy", "from reported"))
    table.caption = (
        "in units of what healthy drives differ by from day to day: "
        "how far the truth is from a healthy robot, and from what was reported"
    )
    for audit in audits:
        right = "right" if audit.right else "wrong"
        distances = f"{audit.truth_alone:.2f}", f"{audit.left:.2f}"
        table.add_row(audit.name, audit.truth, audit.reported, right, *distances)
    return table


def _target(line: Line) -> str:
    return "" if line.target is None else f"{'<=' if line.most else '>='} {line.target:.2f}"


def missed_table(title: str, labels: Mapping[str, Any], answers: Answers) -> Table:
    """Return a table of what is answered where the effect that is concealed has no name, a row for each."""
    table = new_table(title, ("effect",), ("cases", *OUTCOMES))
    for effect, counts in left_out_rows(labels, answers).items():
        table.add_row(effect, str(counts.total()), *(str(counts[outcome]) for outcome in OUTCOMES))
    return table


def prove(
    world: Annotated[
        list[str] | None,
        typer.Option(
            help="A world to ask about: engine, wide, nameless, mujoco, concealed, concealed2, contact, "
            "contact2, unnamed, bullet, injections or optiodom. All of them where none is named."
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
