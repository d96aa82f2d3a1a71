"""A snapshot of a bus as lines of text, at any width, readable without colours."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from rich.text import Text

from omnimate.files.logs.canopen_words import HEARTBEAT, nmt_state_in_words
from omnimate.files.logs.filters import KINDS, FilterError, FrameFilter, IdentifierRule
from omnimate.files.logs.frames import ERROR, EXTENDED, FD, REMOTE, frames_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from omnimate.driver.robot.bus_watch import Snapshot
    from omnimate.driver.robot.events import Event
    from omnimate.driver.robot.robot_watch import RobotView
    from omnimate.files.logs.decoding import FrameDecoder
    from omnimate.files.logs.live_table import LiveRow

SHOWN_BYTES = 8  # of a frame; of a longer frame one fewer, and the number of the others
CHANGED, SILENT, PROBLEM, HEAD = "bold yellow", "dim", "bold red", "bold"


class Wanted(NamedTuple):
    """Which rows are wanted: by identifier, node and kind as in `dump`, and by words in them.

    Each of the words, in small letters, must stand in the meaning of a row.
    """

    frames: FrameFilter
    words: tuple[str, ...] = ()

    @classmethod
    def of(cls, text: str) -> Wanted:
        """Return the filter of `181 180-1FF ~080 node:5 kind:pdo left`: identifiers, node, kind, words."""
        rules, nodes, kinds, words = list[IdentifierRule](), list[int](), list[str](), list[str]()
        for word in text.split():
            name, colon, value = word.partition(":")
            if name == "node" and value.isdigit():
                nodes.append(int(value))
            elif name == "kind" and value in KINDS:
                kinds.append(value)
            else:
                try:
                    rules.append(IdentifierRule.of(word))
                except FilterError:
                    words.append((value if colon and not name else word).lower())
        return cls(FrameFilter(tuple(rules), tuple(nodes), tuple(kinds)), tuple(words))

    def rows(self, rows: Sequence[LiveRow], decoder: FrameDecoder) -> list[LiveRow]:
        """Return the rows that are wanted, in their order."""
        if self.frames != FrameFilter():
            last = frames_of([row.frame._replace(data=row.frame.data[:8], length=None) for row in rows])
            rows = [row for row, wanted in zip(rows, self.frames.wants(last).tolist(), strict=True) if wanted]
        return [row for row in rows if all(word in meaning(row, decoder).lower() for word in self.words)]


def head_line(snapshot: Snapshot, name: str, bitrate: int | None) -> Text:
    """Return how full the bus is, and for how long it has been watched."""
    traffic = snapshot.traffic
    if bitrate:
        load = f"load {100.0 * traffic.least / bitrate:.0f}-{100.0 * traffic.most / bitrate:.0f} %"
    else:
        load = f"{1e-3 * traffic.least:.0f}-{1e-3 * traffic.most:.0f} kbit/s"
    minutes, seconds = divmod(int(snapshot.since), 60)
    words = [f"{traffic.rate:.0f} frames/s", load, f"{snapshot.frames} frames", f"{minutes}:{seconds:02d}"]
    text = Text("  ".join(words), style=HEAD)
    if snapshot.left_out:
        text.append(f"  {snapshot.left_out} left out", style=PROBLEM)
    if snapshot.lost is not None:
        text.append("  BUS LOST", style=PROBLEM)
    if snapshot.has_ended:
        text.append("  the log has ended")
    if snapshot.recording is not None:
        text.append(f"  RECORDING {snapshot.recording.name}", style=PROBLEM)
    return text.append(f"  {name}", style="")


def table_lines(
    rows: Sequence[LiveRow], decoder: FrameDecoder, width: int, *, marks: bool = False
) -> Iterator[Text]:
    """Yield the head of the table, then one line for each identifier.

    A line has `width` characters; `marks` puts a star before each byte that changed, where there are no
    colours.
    """
    channels = {row.frame.channel for row in rows}
    before = 1 + max(map(len, channels)) if len(channels) > 1 else 0
    heads = f"{'':<{before}}{'id':>8} {'Hz':>7} {'+-ms':>6}  {'data':<24} meaning"
    yield _cut(Text(heads, style=HEAD), width)
    for row in rows:
        line = Text(f"{row.frame.channel:<{before}}" if before else "")
        rate = f"{row.rate:7.1f} {1e3 * row.jitter:6.2f}" if row.rate else f"{_age(row.age):>14}"
        line.append(f"{identifier(row):>8} {rate}  ")
        line.append_text(_data(row, marks=marks))
        line.append(f" {meaning(row, decoder)}")
        if not row.rate:
            line.stylize(SILENT)
        yield _cut(line, width)


def node_line(snapshot: Snapshot, width: int) -> Text:
    """Return the last NMT state of each node, and the nodes whose heartbeat is lost."""
    silent = {
        (row.frame.channel, row.frame.can_id & 0x7F)
        for row in snapshot.rows
        if row.frame.can_id & 0x780 == HEARTBEAT and row.frames > 1 and not row.rate
    }
    several = len({channel for channel, _ in snapshot.nodes}) > 1
    states: dict[str, list[str]] = {}
    for (channel, node), seen in sorted(snapshot.nodes.items()):
        state = "heartbeat lost" if (channel, node) in silent else nmt_state_in_words(seen.state)
        states.setdefault(state, []).append(f"{channel}:{node}" if several else f"{node}")
    text = Text("nodes: " if states else "nodes: none has said its state")
    for number, (state, nodes) in enumerate(states.items()):
        words = f"{', ' if number else ''}{state} {' '.join(nodes)}"
        text.append(words, style=PROBLEM if state == "heartbeat lost" else "")
    return _cut(text, width)


def robot_lines(robot: RobotView, width: int) -> Iterator[Text]:
    """Yield the speeds of the wheels, the joints and the link, and the pose of each truck by odometry."""
    wheels = "  ".join(f"{wheel} {speed:+z.3f}" for wheel, speed in robot.speeds.items())
    yield _cut(Text(f"wheels [m/s]: {wheels}".replace("+nan", "?")), width)
    if robot.linkage:
        angles = "  ".join(
            f"{channel} {_degrees(value):+z.2f} degrees"
            for channel, value in robot.linkage.items()
            if channel != "link"
        )
        yield _cut(Text(f"{angles}  link {1e3 * robot.linkage['link']:.1f} mm"), width)
    poses = [
        f"{truck}: x {x:z.3f} m  y {y:z.3f} m  {_degrees(theta):z.1f} degrees"
        for truck, (x, y, theta) in robot.poses.items()
    ]
    text = Text("  ".join(poses))
    if robot.missing:
        text.append(f"  missing: {', '.join(robot.missing)}", style=PROBLEM)
    yield _cut(text, width)


def event_lines(snapshot: Snapshot, most: int, width: int) -> Iterator[Text]:
    """Yield the last events, the newest one last."""
    for event in sorted(snapshot.events, key=lambda event: event.last)[-most:]:
        yield _cut(Text(_event(event, snapshot), style=PROBLEM if event.is_problem else ""), width)


def identifier(row: LiveRow) -> str:
    """Return an identifier as candump prints it."""
    if row.frame.flags & ERROR:
        return "error"
    return f"{row.frame.can_id:08X}" if row.frame.flags & EXTENDED else f"{row.frame.can_id:03X}"


def meaning(row: LiveRow, decoder: FrameDecoder) -> str:
    """Return what the last frame of an identifier means."""
    if row.frame.flags & FD:
        return f"CAN FD, {len(row.frame.data)} bytes"
    return decoder(row.frame)


def _data(row: LiveRow, *, marks: bool) -> Text:
    """Return the data of the last frame, 24 characters wide, with what changed in bold or after a star."""
    frame = row.frame
    if frame.flags & REMOTE:
        return Text(f"remote, {frame.length} bytes".ljust(24))
    text = Text()
    shown = SHOWN_BYTES if len(frame.data) <= SHOWN_BYTES else SHOWN_BYTES - 1
    for byte, changed in zip(frame.data[:shown], row.changed, strict=False):
        text.append("*" if marks and changed else " " if text else "" if not marks else " ")
        text.append(f"{byte:02X}", style=CHANGED if changed else "")
    if len(frame.data) > shown:
        text.append(f" +{len(frame.data) - shown}")
    text.pad_right(max(0, 24 - len(text)))
    return text


def _event(event: Event, snapshot: Snapshot) -> str:
    ago = max(0.0, snapshot.time - event.last)
    node = "bus" if event.node is None else f"node {event.node}"
    often = f" ({event.count} times)" if event.count > 1 else ""
    return f"{_age(ago):>11}  {node:<8} {event.what}{often}"


def _age(seconds: float) -> str:
    if seconds < 99.5:
        return f"{seconds:.1f} s ago"
    return f"{seconds / 60.0:.0f} min ago" if seconds < 5970.0 else f"{seconds / 3600.0:.0f} h ago"


def _degrees(angle: float) -> float:
    return math.degrees(math.remainder(angle, 2.0 * math.pi))


def _cut(text: Text, width: int) -> Text:
    text.truncate(width, overflow="ellipsis")
    return text
