"""Tables of how often answers about a corpus are right."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from rich.table import Table

from omnimate.proof.leave_one_out import OUTCOMES, left_out_rows
from omnimate.proof.score import reported_instead, rows

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from omnimate.evaluation.questions import Answers
    from omnimate.proof.audit import Audit
    from omnimate.proof.score import Row


def shown(title: str, labels: Mapping[str, Any], answers: Answers, ease: float = 1.0) -> Table:
    """Return a table of what a tool's answers are worth; `ease` is a factor on the targets."""
    table = Table(title=title)
    for heading in ("what", "share", "95 %", "of", "target", ""):
        table.add_column(heading, justify="left" if heading in {"what", ""} else "right")
    for row in rows(labels, answers, ease):
        table.add_row(*_cells(row), style="" if row.verdict != "NOT REACHED" else "bold")
    return table


def _cells(row: Row) -> tuple[str, ...]:
    if math.isnan(row.share):
        return row.name, "-", "", "0", "", row.note
    low, high = row.interval
    return (
        row.name,
        f"{row.share:.3f}",
        f"{low:.2f}-{high:.2f}",
        str(row.of),
        _target(row),
        f"{row.verdict} {row.note}".strip(),
    )


def instead(title: str, labels: Mapping[str, Any], answers: Answers) -> Table:
    """Return a table of the names that counted as right in the truth's place, for who judges otherwise."""
    table = Table(title=f"{title}: counted as right, as the drive cannot tell them apart")
    for heading in ("truth", "reported first", "cases"):
        table.add_column(heading, justify="right" if heading == "cases" else "left")
    for (truth, reported), cases in reported_instead(labels, answers).most_common():
        table.add_row(truth, reported, str(cases))
    return table


def redriven(title: str, audits: Sequence[Audit]) -> Table:
    """Return a table of what was reported in the truth's place, and how far off the engine drives it."""
    table = Table(
        title=f"{title}: reported in the truth's place, driven by the engine itself",
        caption="in units of what healthy drives differ by from day to day: "
        "how far the truth is from a healthy robot, and from what was reported",
    )
    for heading in ("case", "truth", "reported", "counts as", "from healthy", "from reported"):
        table.add_column(heading, justify="right" if heading.startswith("from") else "left")
    for audit in audits:
        right = "right" if audit.right else "wrong"
        distances = f"{audit.truth_alone:.2f}", f"{audit.left:.2f}"
        table.add_row(audit.name, audit.truth, audit.reported, right, *distances)
    return table


def compared(
    title: str, labels: Mapping[str, Any], answers: Mapping[str, Answers], ease: float = 1.0
) -> Table:
    """Return a table of what the answers of several tools are worth, a column for each."""
    table = Table(title=title)
    for heading in ("what", "wanted", *answers):
        table.add_column(heading, justify="left" if heading == "what" else "right")
    for line in zip(*(rows(labels, each, ease) for each in answers.values()), strict=True):
        table.add_row(line[0].name, _target(line[0]), *map(_share, line))
    return table


def _target(row: Row) -> str:
    return "" if row.target is None else f"{'<=' if row.most else '>='} {row.target:.2f}"


def _share(row: Row) -> str:
    return f"{row.share:.2f} of {row.of}" if row.of else "-"


def missed(title: str, labels: Mapping[str, Any], answers: Answers) -> Table:
    """Return a table of what is answered where the effect that is concealed has no name, a row for each."""
    table = Table(title=title)
    for heading in ("effect", "cases", *OUTCOMES):
        table.add_column(heading, justify="left" if heading == "effect" else "right")
    for row in left_out_rows(labels, answers):
        table.add_row(row.effect, str(row.cases), *(str(row.outcomes.get(each, 0)) for each in OUTCOMES))
    return table
