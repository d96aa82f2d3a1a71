"""What the driver found and what happened, as tables."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rich.box import SIMPLE_HEAD
from rich.table import Table
from rich.text import Text

from cli.console import out

if TYPE_CHECKING:
    from driver.configure import ConfigurationReport
    from driver.report import DriverReport

SHOWN_EVENTS = 40


def show_configuration(report: ConfigurationReport, *, verbose: bool = False) -> None:
    """Print the bus load, what was changed at each node, and what to read; all that was found if verbose."""
    out.print(f"bus load: {report.load.in_words()}", soft_wrap=True)
    table = Table("node", "channel", "", "", box=SIMPLE_HEAD)
    for one in report.nodes:
        kinds = [("found", one.found if verbose else ()), ("changed", one.changed), ("remark", one.remarks)]
        lines = [(kind, line) for kind, lines in kinds for line in lines] or [("", "as it must be")]
        for number, (kind, line) in enumerate(lines):
            first = (str(one.node), ", ".join(one.names)) if number == 0 else ("", "")
            table.add_row(*first, kind, Text(line))
    out.print(table)


def show_report(report: DriverReport) -> None:
    """Print the frames of each node and what happened, or that nothing did."""
    if report.is_clean:
        out.print(f"  {report.syncs} SYNCs, each answered by every node in time", highlight=False)
        return
    table = Table(box=SIMPLE_HEAD, title=f"{report.syncs} SYNCs", title_justify="left")
    heads = ("node", "what", "state", "received", "missing", "late", "double", "length", "unknown", "jumps")
    for head in (*heads, "restarts", "EMCY"):
        table.add_column(head, justify="left" if head in {"what", "state"} else "right")
    for one in report.nodes:
        numbers = (
            one.received,
            one.missing,
            one.late,
            one.duplicate,
            one.wrong_length,
            one.unknown,
            one.jumps,
            one.restarts,
            one.emergencies,
        )
        table.add_row(str(one.node), ", ".join(one.names), one.state, *(str(number) for number in numbers))
    out.print(table)
    start = report.events[0].time if report.events else 0.0
    for event in report.events[:SHOWN_EVENTS]:
        node = f"node {event.node}" if event.node is not None else "bus"
        often = f" ({event.count} times until {event.last - start:.2f} s)" if event.count > 1 else ""
        out.print(
            f"  {event.time - start:9.3f} s  {node:<8} {event.what}{often}", markup=False, soft_wrap=True
        )
    hidden = len(report.events) - SHOWN_EVENTS + report.events_dropped
    if hidden > 0:
        out.print(f"  ... and {hidden} more")
    for gap in report.gaps:
        out.print(
            f"  gap: {gap.channel} from {gap.start:.3f} to {gap.end:.3f} s ({gap.reason})", soft_wrap=True
        )
    for identifier, what, frames in report.strangers:
        out.print(f"  not of this vehicle: {identifier} {what}: {frames} frames")
