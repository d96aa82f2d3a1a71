"""The screen of `omnimate monitor`: what a bus does, at any size of the terminal, with keys to look closer.

Only this file uses the library `textual`, which is optional.
"""

from __future__ import annotations

from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from rich.text import Text
from textual.app import App, ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import VerticalScroll
from textual.widgets import Footer, Input, Static

from omnimate.cli.monitor.lines import (
    Wanted,
    event_lines,
    head_line,
    node_line,
    robot_lines,
    table_lines,
)
from omnimate.driver.robot.bus_watch import REFRESH
from omnimate.vehicle.atomic import write_text

if TYPE_CHECKING:
    from collections.abc import Iterable

    from omnimate.cli.descriptions import Descriptions
    from omnimate.driver.robot.bus_watch import BusWatch, Snapshot
    from omnimate.files.logs.live_table import LiveRow

EVENTS = 4  # lines

ORDERS = ("identifier", "rate", "newest")


class MonitorApp(App[None]):
    """Shows the snapshots of a watch until `q`.

    `paused` is the snapshot at which the screen stands still, None while it follows; `order` is one of
    `ORDERS`.
    """

    CSS = """
    #head, #robot, #events { height: auto; }
    #table { height: 1fr; }
    #robot, #events { border-top: solid $secondary; }
    #filter { display: none; height: 1; border: none; }
    #filter.open { display: block; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("q", "quit", "quit"),
        Binding("space", "pause", "pause"),
        Binding("slash", "filter", "filter"),
        Binding("s", "sort", "sort"),
        Binding("r", "record", "record"),
        Binding("escape", "close_filter", show=False),
    ]
    ENABLE_COMMAND_PALETTE = False

    def __init__(
        self,
        watch: BusWatch,
        known: Descriptions,
        *,
        name: str,
        bitrate: int | None = None,
        wanted: Wanted,
        target: Path | None = None,
        seconds: float | None = None,
        picture: Path | None = None,
        marks: bool = False,
    ) -> None:
        """Prepare the screen.

        `bitrate` [bit/s] is that of which the load is a share, `target` what `r` records into (None names it
        by the time), `picture` an SVG file of the screen in the end; `marks` puts a star before changed
        bytes.
        """
        super().__init__()
        self.bus_watch = watch
        self.wanted = wanted
        self.paused: Snapshot | None = None
        self.order = ORDERS[0]
        self._known = known
        self._seen: dict[tuple[int, int, int], int] = {}
        self._decoder = known.decoder({})
        self._bus_name, self._bitrate, self._target = name, bitrate, target
        self._seconds, self._picture, self._marks = seconds, picture, marks
        self._filter = ""
        # kept, and not asked of the screen: a timer may still draw while the screen is taken down
        self._parts = {part: Static(id=part) for part in ("head", "rows", "robot", "events")}

    def compose(self) -> ComposeResult:
        """Place the parts of the screen."""
        yield self._parts["head"]
        with VerticalScroll(id="table"):
            yield self._parts["rows"]
        yield self._parts["robot"]
        yield self._parts["events"]
        yield Input(id="filter", placeholder="181 180-1FF ~080 node:5 kind:pdo left")
        yield Footer()

    def on_mount(self) -> None:
        """Begin to follow the watch."""
        self.query_one("#table").focus()
        self.set_interval(REFRESH, self.show)
        if self._seconds is not None:
            self.set_timer(self._seconds, self._end)
        self.show()

    def show(self) -> None:
        """Draw the last snapshot, or the one at which the screen stands still."""
        snapshot = self.paused or self.bus_watch.snapshot
        if snapshot.seen != self._seen and self.bus_watch.vehicle is None:
            self._seen = dict(snapshot.seen)
            self._decoder = self._known.decoder(self._seen)
        width = self.size.width
        head = head_line(snapshot, self._bus_name, self._bitrate)
        if self._filter:
            head = Text(f"filter: {self._filter}  ").append_text(head)
        if self.paused is not None:
            head = Text("PAUSED  ", style="bold reverse").append_text(head)
        head.truncate(width, overflow="ellipsis")
        rows = self._sorted(self.wanted.rows(snapshot.rows, self._decoder))
        self._update("head", [head])
        self._update("rows", table_lines(rows, self._decoder, width - 2, marks=self._marks))
        robot = [] if snapshot.robot is None else list(robot_lines(snapshot.robot, width))
        self._update("robot", [node_line(snapshot, width), *robot])
        self._update("events", event_lines(snapshot, EVENTS, width))

    def _end(self) -> None:
        if self._picture is not None:
            write_text(self._picture, self.export_screenshot(title=f"omnimate monitor {self._bus_name}"))
        self.exit()

    def action_pause(self) -> None:
        """Stand still, or follow again; frames are counted all the same."""
        self.paused = self.bus_watch.snapshot if self.paused is None else None
        self.show()

    def action_sort(self) -> None:
        """Sort by the next of `ORDERS`."""
        self.order = ORDERS[(ORDERS.index(self.order) + 1) % len(ORDERS)]
        self.notify(f"sorted by {self.order}", timeout=2.0)
        self.show()

    def action_record(self) -> None:
        """Begin to record, or end it."""
        if self.bus_watch.snapshot.recording is not None:
            self.bus_watch.record(None)
        else:
            self.bus_watch.record(self._target or self._new_target())

    def action_filter(self) -> None:
        """Ask for a filter."""
        field = self.query_one("#filter", Input)
        field.value = self._filter
        field.add_class("open")
        field.focus()

    def action_close_filter(self) -> None:
        """Leave the filter as it is."""
        self.query_one("#filter").remove_class("open")
        self.query_one("#table").focus()

    def on_input_submitted(self, event: Input.Submitted) -> None:
        """Show what the filter wants."""
        self._filter = event.value.strip()
        self.wanted = Wanted.of(self._filter)
        self.action_close_filter()
        self.show()

    def _sorted(self, rows: list[LiveRow]) -> list[LiveRow]:
        if self.order == "rate":
            return sorted(rows, key=lambda row: -row.rate)
        return sorted(rows, key=lambda row: row.age) if self.order == "newest" else rows

    def _new_target(self) -> Path:
        stamp = datetime.now().astimezone().strftime("%Y%m%d-%H%M%S")
        return Path(f"recording-{stamp}" if self.bus_watch.vehicle is not None else f"recording-{stamp}.log")

    def _update(self, part: str, lines: Iterable[Text]) -> None:
        self._parts[part].update(Text("\n").join(lines))
