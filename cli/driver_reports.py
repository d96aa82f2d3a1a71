"""The driver's configuration and report, as tables."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.cli.console import out, report_problem, say
from omnimate.cli.tables import new_table, show

if TYPE_CHECKING:
    from rich.table import Table

    from omnimate.driver.robot.configure import ConfigurationReport
    from omnimate.driver.robot.report import DriverReport

MAX_SHOWN = 40  # events, and gaps
COUNTERS = {
    "received": "PDOs",
    "missing": "missing",
    "late": "late",
    "duplicate": "double",
    "wrong_length": "wrong length",
    "unknown": "unknown",
    "jumps": "jumps",
    "restarts": "restarts",
    "emergencies": "EMCY",
}


def show_configuration(report: ConfigurationReport, *, verbose: bool = False) -> None:
    """Print the bus load, what was changed at each node, and what to read; all that was found if verbose."""
    say(report.load.in_words())
    table = new_table("", ("node", "channel", "", "what"))
    for node in report.nodes:
        lines = [line for line in node.lines() if verbose or line[0] != "found"] or [("", "as it must be")]
        for number, (kind, line) in enumerate(lines):
            first = (str(node.node), ", ".join(node.names)) if number == 0 else ("", "")
            table.add_row(*first, kind, line)
    show(table, folds=True)


def show_report(report: DriverReport) -> None:
    """Print the frames of each node, events and gaps, or that there were none; report the problems."""
    if report.is_clean:
        out.print(f"  {report.syncs} SYNCs, each answered by every node in time")
        return
    show(_node_table(report))
    _show_events(report)
    _show_gaps(report)
    for identifier, what, frames in report.unknown_frames:
        say(f"  not of this vehicle: {identifier} {what}: {frames} frames")
    report_problems(report)


def report_problems(report: DriverReport) -> None:
    """Report the events that need a repair, so that the exit code is 1."""
    for event in report.problems:
        report_problem(event.what if event.node is None else f"node {event.node}: {event.what}")


def _node_table(report: DriverReport) -> Table:
    """Return the table of the nodes, with the counters that are not all zero."""
    nodes = report.nodes
    heads = {name: head for name, head in COUNTERS.items() if any(getattr(node, name) for node in nodes)}
    rows = [
        (str(node.node), ", ".join(node.names), node.state, *(str(getattr(node, name)) for name in heads))
        for node in nodes
    ]
    return new_table(f"{report.syncs} SYNCs", ("node", "what", "state"), tuple(heads.values()), rows)


def _show_events(report: DriverReport) -> None:
    """Print the events, timed from the first SYNC."""
    for event in report.events[:MAX_SHOWN]:
        node = f"node {event.node}" if event.node is not None else "bus"
        until = event.last - report.started
        often = f" ({event.count} times until {until:.2f} s)" if event.count > 1 else ""
        at = event.time - report.started
        say(f"  {at:9.3f} s  {node:<8} {event.what}{often}")
    hidden = max(0, len(report.events) - MAX_SHOWN) + report.events_dropped
    if hidden:
        out.print(f"  and {hidden} more events")


def _show_gaps(report: DriverReport) -> None:
    """Print the gaps, those of several channels at the same time in one line."""
    same: dict[tuple[float, float, str], list[str]] = {}
    for gap in report.gaps:
        same.setdefault((gap.start, gap.end, gap.reason), []).append(gap.channel)
    for (start, end, reason), channels in list(same.items())[:MAX_SHOWN]:
        when = f"{start - report.started:9.3f} to {end - report.started:.3f} s"
        say(f"  gap: {when}, {', '.join(channels)} ({reason})")
    if len(same) > MAX_SHOWN:
        out.print(f"  and {len(same) - MAX_SHOWN} more gaps")
