"""Tables of what answers about a corpus are worth."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from rich.table import Table

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from cli.proving import Answers
    from proof.audit import Audit
    from proof.score import Row


def shown(title: str, labels: Mapping[str, Any], answers: Answers, ease: float = 1.0) -> Table:
    """Return a table of what a tool's answers are worth; `ease` is a factor on the targets."""
    from proof.score import rows

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
    from proof.score import told_instead

    table = Table(title=f"{title}: counted as right, as the drive cannot tell them apart")
    for heading in ("truth", "told first", "cases"):
        table.add_column(heading, justify="right" if heading == "cases" else "left")
    for (truth, told), cases in told_instead(labels, answers).most_common():
        table.add_row(truth, told, str(cases))
    return table


def redriven(title: str, audits: Sequence[Audit]) -> Table:
    """Return a table of what was told in the truth's place, and how far off it is as the engine drives it."""
    table = Table(
        title=f"{title}: what was told in the truth's place, driven by the engine itself",
        caption="in units of what healthy drives differ by from day to day: "
        "how far the truth is from a healthy robot, and from what was told",
    )
    for heading in ("case", "truth", "told", "counts as", "from healthy", "from told"):
        table.add_column(heading, justify="right" if heading.startswith("from") else "left")
    for one in audits:
        right = "right" if one.right else "wrong"
        table.add_row(one.name, one.truth, one.told, right, f"{one.truth_alone:.2f}", f"{one.left:.2f}")
    return table


def compared(
    title: str, labels: Mapping[str, Any], answers: Mapping[str, Answers], ease: float = 1.0
) -> Table:
    """Return a table of what the answers of several tools are worth, a column for each."""
    from proof.score import rows

    table = Table(title=title)
    for heading in ("what", "wanted", *answers):
        table.add_column(heading, justify="left" if heading == "what" else "right")
    for line in zip(*(rows(labels, own, ease) for own in answers.values()), strict=True):
        table.add_row(line[0].name, _target(line[0]), *map(_share, line))
    return table


def _target(row: Row) -> str:
    return "" if row.target is None else f"{'<=' if row.most else '>='} {row.target:.2f}"


def _share(row: Row) -> str:
    return f"{row.share:.2f} of {row.of}" if row.of else "-"


def missed(title: str, labels: Mapping[str, Any], answers: Answers) -> Table:
    """Return a table of what is answered where the effect that is concealed has no name, a row for each."""
    from proof.leave_one_out import OUTCOMES, left_out_rows

    table = Table(title=title)
    for heading in ("effect", "cases", *OUTCOMES):
        table.add_column(heading, justify="left" if heading == "effect" else "right")
    for row in left_out_rows(labels, answers):
        table.add_row(row.effect, str(row.cases), *(str(row.outcomes.get(one, 0)) for one in OUTCOMES))
    return table
