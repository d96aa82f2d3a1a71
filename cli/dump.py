"""`omnimate dump`: a log or a live bus as candump prints it, in words and in parts where asked."""

from __future__ import annotations

import contextlib
import itertools
import math
import signal
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
import typer

from omnimate.cli.console import warn
from omnimate.cli.descriptions import descriptions, vehicle_of
from omnimate.cli.errors import CallError
from omnimate.cli.loading import frames_on_bus, log_of
from omnimate.cli.options import DbcFiles, EdsFiles, OptionalLogSource
from omnimate.files.logs.blocks import LogBlocks
from omnimate.files.logs.filters import KINDS, FrameFilter, IdentifierRule, trigger_of, within_seconds
from omnimate.files.logs.formats.candump_blocks import RELATIVE_WIDTH
from omnimate.files.logs.formats.candump_lines import STAMP_WIDTH, format_lines
from omnimate.files.logs.formats.candump_text import candump_text
from omnimate.files.logs.frames import EXTENDED, frames_of
from omnimate.files.logs.rates import RateTable
from omnimate.files.logs.seen_mapping import SeenObjects

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from numpy.typing import NDArray

    from omnimate.cli.descriptions import Descriptions
    from omnimate.files.logs.decoding import FrameDecoder
    from omnimate.files.logs.filters import Trigger
    from omnimate.files.logs.formats.candump_lines import Form
    from omnimate.files.logs.frames import Frames

_AT_ONCE = 1000  # lines of a log that are written together


FormChoice = Literal["log", "ta", "td", "tz"]  # as of candump -L, -ta, -td, -tz


def dump(
    source: OptionalLogSource = None,
    bus: Annotated[str | None, typer.Option(help="Read this bus instead, such as socketcan://can0.")] = None,
    form: Annotated[FormChoice, typer.Option(help="Lines as of candump -L, -ta, -td or -tz.")] = "log",
    identifiers: Annotated[
        list[str] | None,
        typer.Option("--id", help="181, 180-1FF, 700:780 (mask) or ~080 (all others); repeatable."),
    ] = None,
    nodes: Annotated[
        list[int] | None, typer.Option("--node", min=1, max=127, help="CANopen node id; repeatable.")
    ] = None,
    kinds: Annotated[
        list[str] | None,
        typer.Option("--kind", metavar="|".join(KINDS), help="Kind of frame; repeatable."),
    ] = None,
    begin: Annotated[
        float | None, typer.Option("--from", help="From so long after the first frame [s].")
    ] = None,
    end: Annotated[
        float | None, typer.Option("--to", help="Up to so long after the first frame [s].")
    ] = None,
    triggers: Annotated[
        list[str] | None,
        typer.Option("--trigger", help="Only around gap:SECONDS, emcy, error or 'NAME>VALUE'; repeatable."),
    ] = None,
    margin: Annotated[
        float, typer.Option("--around", min=0.0, help="How long before and after a trigger [s].")
    ] = 1.0,
    decode: Annotated[
        bool, typer.Option("--decode", help="Say behind each line what the frame means.")
    ] = False,
    vehicle: Annotated[
        Path | None,
        typer.Option(
            exists=True, help="vehicle.toml whose channels to name; a recording folder has its own."
        ),
    ] = None,
    dbc: DbcFiles = None,
    eds: EdsFiles = None,
    rates: Annotated[
        bool, typer.Option("--rates", help="Print the rate of each identifier instead.")
    ] = False,
    count: Annotated[int | None, typer.Option(min=1, help="End after so many frames.")] = None,
    seconds: Annotated[float | None, typer.Option(min=0.0, help="End a live bus after so long [s].")] = None,
) -> None:
    """Print the frames of a log or of a live bus, all or those that are asked for."""
    if (source is None) == (bus is None):
        raise typer.BadParameter("give either a log file or --bus URL")
    for kind in kinds or ():
        if kind not in KINDS:
            raise typer.BadParameter(f"--kind {kind}: expected one of {', '.join(KINDS)}")
    for option, time in (("--from", begin), ("--to", end)):
        if time is not None and math.isnan(time):
            raise typer.BadParameter(f"{option} nan: expected a time after the first frame, in seconds")
    if begin is not None and end is not None and begin > end:
        raise typer.BadParameter(f"--from {begin:g} is after --to {end:g}; expected it to be before")
    wanted = FrameFilter(
        tuple(IdentifierRule.of(text) for text in identifiers or ()),
        tuple(nodes or ()),
        tuple(kinds or ()),
        begin,
        end,
    )
    robot = vehicle_of(vehicle, source)
    known = descriptions(robot, dbc or (), eds or ())
    if bus is not None and triggers:
        raise CallError("--trigger looks back, so it needs a log; record the bus first")
    log, decoder, near = None, known.decoder({}), None
    if source is not None:
        log, decoder, near = _opened(log_of(source), known, triggers or (), decode=decode)
    chosen = _chosen(log or _blocks_on_bus(str(bus), seconds), wanted, count, near, margin)
    _show(chosen, form, log, decoder, decode=decode, rates=rates)


def _opened(
    path: Path, known: Descriptions, triggers: Sequence[str], *, decode: bool
) -> tuple[LogBlocks, FrameDecoder, NDArray[np.float64] | None]:
    """Return a log to be read, what explains its frames, and the times of its triggers, if any [s]."""
    if triggers and path.is_fifo():
        raise CallError(
            "--trigger looks back, so it needs a log that is a file; write the pipe into one first"
        )
    seen = SeenObjects()
    is_described = known.vehicle is not None and not known.vehicle.eds_files
    if (decode or triggers) and not is_described and not path.is_fifo():
        for frames in LogBlocks(path, fd=True):
            seen.take(frames)
    decoder = known.decoder(seen.values)
    near = _triggered(path, triggers, decoder) if triggers else None
    return LogBlocks(path, fd=True), decoder, near


def _show(
    blocks: Iterator[Frames],
    form: FormChoice,
    log: LogBlocks | None,
    decoder: FrameDecoder,
    *,
    decode: bool,
    rates: bool,
) -> None:
    """Print frames, or their rates at the end, and what is wrong with a log.

    Ctrl-C and SIGTERM end a bus (no log) in good order.
    """
    table = RateTable()
    with contextlib.suppress(*([KeyboardInterrupt] if log is None else [])):
        if rates:
            for frames in blocks:
                table.add(frames)
        else:
            _print(blocks, form, log, decoder if decode else None)
    if rates:
        _write(table.lines(decoder))
    for problem in log.problems() if log is not None else ():
        warn(problem)
    if log is not None and not log.is_whole:
        raise typer.Exit(1)


def _triggered(path: Path, triggers: Sequence[str], decoder: FrameDecoder) -> NDArray[np.float64]:
    """Return the times of all triggers in a log [s], shape `(K,)`, and say when each happened."""
    found: list[tuple[Trigger, list[NDArray[np.float64]]]] = [
        (trigger_of(text, decoder.signals), []) for text in triggers
    ]
    start: float | None = None
    for frames in LogBlocks(path, fd=True):
        start = float(frames.time[0]) if start is None else start
        for trigger, times in found:
            times.append(frames.time[trigger.rows(frames)])
    every = [np.concatenate(times) for _, times in found]
    for text, moments in zip(triggers, every, strict=True):
        first = ", ".join(f"{time:.3f}" for time in (moments[:10] - (start or 0.0)).tolist())
        more = f" and {len(moments) - 10} more" if len(moments) > 10 else ""
        warn(f"{text}: {len(moments)} times" + (f", at {first} s{more}" if len(moments) else ""))
    return np.concatenate(every)


def _chosen(
    blocks: Iterable[Frames],
    wanted: FrameFilter,
    count: int | None,
    near: NDArray[np.float64] | None,
    margin: float,
) -> Iterator[Frames]:
    """Yield the wanted frames of a log or a bus, block by block.

    At most `count`, and only those within `margin` [s] of the times `near` [s], where these are given.
    """
    start: float | None = None
    is_filtered = near is not None or wanted != FrameFilter()  # a bus gives frame by frame: each costs
    for frames in blocks:
        part = frames
        if is_filtered:
            start = float(frames.time[0]) if start is None else start
            rows = wanted.wants(frames, start)
            if near is not None:
                rows &= within_seconds(frames, near, margin)
            part = frames if rows.all() else frames.select(rows)
        part = part if count is None else part.select(slice(count))
        if len(part):
            yield part
        if count is not None and (count := count - len(part)) == 0:
            return


def _print(
    blocks: Iterator[Frames], form: FormChoice, log: LogBlocks | None, decoder: FrameDecoder | None
) -> None:
    """Print frames, with what they mean where there is a decoder; those of a bus (no log) at once."""
    times, indent = _Times(form), False
    sys.stdout.flush()
    for frames in blocks:
        shown = times.shown(frames)
        stamp_width = STAMP_WIDTH if log is None else log.stamp_width
        width = RELATIVE_WIDTH if form in {"td", "tz"} else stamp_width
        if log is not None and decoder is None:
            for text in candump_text(shown, _layout(form), width, indent=indent):
                sys.stdout.buffer.write(text)
        else:
            lines = format_lines(shown, _layout(form), width, indent=indent)
            if decoder is not None:
                lines = (f"{line}  ; {decoder(frame)}" for line, frame in zip(lines, frames, strict=True))
            _write(lines)
        indent = indent or bool(np.any(frames.flags & EXTENDED))
    sys.stdout.buffer.flush()


class _Times:
    """The times that a form prints, of frames that come block by block."""

    def __init__(self, form: FormChoice) -> None:
        self._form = form
        self._since: float | None = None

    def shown(self, frames: Frames) -> Frames:
        """Return frames, of which there are some, with the times that are printed."""
        if self._form in {"log", "ta"}:
            return frames
        since = float(frames.time[0]) if self._since is None else self._since
        if self._form == "tz":
            times, self._since = frames.time - since, since
        else:
            times, self._since = np.diff(frames.time, prepend=since), float(frames.time[-1])
        return replace(frames, time=np.maximum(times, 0.0))


def _layout(form: FormChoice) -> Form:
    """Return the form of a line, whatever its time."""
    return "log" if form == "log" else "ta"


def _write(lines: Iterator[str]) -> None:
    while block := list(itertools.islice(lines, _AT_ONCE)):
        sys.stdout.write("\n".join(block) + "\n")
    sys.stdout.flush()


def _blocks_on_bus(url: str, seconds: float | None) -> Iterator[Frames]:
    """Yield each frame of a bus as it comes; SIGTERM ends it as Ctrl-C does."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    with contextlib.closing(frames_on_bus(url, seconds, fd=True)) as frames:
        for frame in frames:
            yield frames_of([frame])
