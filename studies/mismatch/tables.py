"""Tables of how often answers about a corpus are right."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from rich.table import Table
from rich.text import Text

from omnimate.cli.tables import new_table
from studies.mismatch.run import Answers
from studies.mismatch.scoring.audit import Audit
from studies.mismatch.scoring.leave_one_out import OUTCOMES, left_out_rows
from studies.mismatch.scoring.score import Line, Score

ERRORS = ("nominal", "least squares", "found")  # the ways to predict what was not seen


def worlds(scores: Sequence[Score]) -> Table:
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


def open_loop(title: str, labels: Mapping[str, Any], answers: Answers) -> Table:
    """Return a table of position errors on recordings that were not seen, a row for each case."""
    what = f"{title}: position error on the other half after 10 s of open loop, rms [mm]"
    table = new_table(what, ("case",), ERRORS)
    table.add_column("first findings")
    for case in labels:
        errors = answers[case].get("open_loop")
        shown = ("-",) * len(ERRORS) if errors is None else [f"{1e3 * errors[each]:.1f}" for each in ERRORS]
        findings = [
            f"{finding['effect']} {finding['component']} {finding['probability']:.0%}"
            for finding in answers[case]["findings"][:3]
        ]
        table.add_row(case, *shown, "; ".join(findings) or answers[case]["verdict"])
    return table


def instead(title: str, reported: Counter[tuple[str, str]]) -> Table:
    """Return a table of the names that counted as right in the truth's place, for who judges otherwise."""
    what = f"{title}: counted as right, as the drive cannot tell them apart"
    table = new_table(what, ("truth", "reported first"), ("cases",))
    for (truth, name), cases in reported.most_common():
        table.add_row(truth, name, str(cases))
    return table


def redriven(title: str, audits: Sequence[Audit]) -> Table:
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


def missed(title: str, labels: Mapping[str, Any], answers: Answers) -> Table:
    """Return a table of what is answered where the effect that is concealed has no name, a row for each."""
    table = new_table(title, ("effect",), ("cases", *OUTCOMES))
    for effect, counts in left_out_rows(labels, answers).items():
        table.add_row(effect, str(counts.total()), *(str(counts[each]) for each in OUTCOMES))
    return table
