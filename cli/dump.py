"""`omnimate dump`: a log or a live bus as candump prints it, in words and in parts where asked."""

from __future__ import annotations

import contextlib
import itertools
import signal
import sys
import time
from dataclasses import replace
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer

from omnimate.cli.console import warn
from omnimate.cli.descriptions import DbcFiles, EdsFiles, descriptions, vehicle_of
from omnimate.cli.errors import CallError
from omnimate.cli.loading import log_of
from omnimate.logs.dbc_reading import EXTENDED_KEY
from omnimate.logs.filters import FrameFilter, IdentifierRule, around, trigger_of
from omnimate.logs.formats.candump_blocks import RELATIVE_WIDTH
from omnimate.logs.formats.candump_lines import format_frame, format_lines
from omnimate.logs.formats.candump_text import candump_text
from omnimate.logs.formats.python_can_logs import frame_of_message
from omnimate.logs.frames import EXTENDED, Frame, frames_of
from omnimate.logs.rates import rate_lines
from omnimate.logs.reading import read_log
from omnimate.logs.seen_mapping import seen_objects

if TYPE_CHECKING:
    from collections.abc import Generator, Iterator, Sequence

    from omnimate.logs.decoding import FrameDecoder
    from omnimate.logs.formats.candump_lines import Form
    from omnimate.logs.frames import Frames

_POLL = 0.2  # [s] after which a silent bus is asked again
_AT_ONCE = 1000  # lines of a log that are written together


class FormChoice(Enum):
    """How a line looks: as of candump `-L`, `-ta`, `-td` or `-tz`."""

    log = "log"
    ta = "ta"
    td = "td"
    tz = "tz"

    @property
    def layout(self) -> Form:
        """Form of the line, whatever its time."""
        return "log" if self is FormChoice.log else "ta"


class KindChoice(Enum):
    """Kinds of frames."""

    nmt = "nmt"
    sync = "sync"
    emcy = "emcy"
    time = "time"
    pdo = "pdo"
    sdo = "sdo"
    heartbeat = "heartbeat"
    lss = "lss"
    remote = "remote"
    error = "error"
    foreign = "foreign"


def dump(
    source: Annotated[
        Path | None, typer.Argument(help="Log file (candump, .asc, .blf, .trc; .gz too) or recording folder.")
    ] = None,
    bus: Annotated[str | None, typer.Option(help="Read this bus instead, such as socketcan://can0.")] = None,
    form: Annotated[
        FormChoice, typer.Option(help="Lines as of candump -L, -ta, -td or -tz.")
    ] = FormChoice.log,
    identifiers: Annotated[
        list[str] | None,
        typer.Option("--id", help="181, 180-1FF, 700:780 (mask) or ~080 (all others); repeatable."),
    ] = None,
    nodes: Annotated[
        list[int] | None, typer.Option("--node", min=1, max=127, help="CANopen node id; repeatable.")
    ] = None,
    kinds: Annotated[
        list[KindChoice] | None, typer.Option("--kind", help="Kind of frame; repeatable.")
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
        Path | None, typer.Option(help="vehicle.toml whose channels to name; a recording folder has its own.")
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
    wanted = FrameFilter(
        tuple(IdentifierRule.of(text) for text in identifiers or ()),
        tuple(nodes or ()),
        tuple(kind.value for kind in kinds or ()),
        begin,
        end,
    )
    robot = vehicle_of(vehicle, source)
    known = descriptions(robot, dbc or (), eds or ())
    if bus is not None:
        if triggers:
            raise CallError("--trigger looks back, so it needs a log; record the bus first")
        decoder = known.decoder({})
        _dump_bus(_live(bus, wanted, count, seconds), form, decoder, decode, rates)
        return
    assert source is not None  # one of the two is given
    log = read_log(log_of(source))
    frames = log.frames
    seen = seen_objects(frames) if (decode or triggers) and (robot is None or robot.eds_files) else {}
    decoder = known.decoder(seen)
    chosen = wanted.wants(frames)
    if triggers:
        chosen &= _near(frames, triggers, decoder, margin)
    if not chosen.all():
        frames = frames.select(chosen)
    frames = frames if count is None else frames.select(slice(count))
    _dump_log(frames, form, log.stamp_width, decoder, decode, rates)
    for problem in log.problems():
        warn(problem)
    if not log.is_whole:
        raise typer.Exit(1)


def _near(frames: Frames, triggers: Sequence[str], decoder: FrameDecoder, margin: float) -> np.ndarray:
    """Return which frames are near a trigger, shape `(N,)`, and say when each happened."""
    found = [trigger_of(text, decoder.signals, EXTENDED_KEY).rows(frames) for text in triggers]
    for text, rows in zip(triggers, found, strict=True):
        times = ", ".join(f"{time:.3f}" for time in (frames.time[rows[:10]] - frames.time[0]).tolist())
        more = f" and {len(rows) - 10} more" if len(rows) > 10 else ""
        warn(f"{text}: {len(rows)} times" + (f", at {times} s{more}" if len(rows) else ""))
    return around(frames, np.concatenate(found), margin)


def _dump_log(
    frames: Frames, form: FormChoice, stamp_width: int, decoder: FrameDecoder, decode: bool, rates: bool
) -> None:
    """Print the frames of a log, or their rates."""
    if rates:
        _write(rate_lines(frames, decoder))
        return
    shown, width = _with_times(frames, form, stamp_width)
    if not len(shown):
        return
    if not decode:
        sys.stdout.flush()
        for text in candump_text(shown, form.layout, width):
            sys.stdout.buffer.write(text)
        sys.stdout.buffer.flush()
        return
    lines = format_lines(shown, form.layout, width)
    _write(f"{line}  ; {decoder(frame)}" for line, frame in zip(lines, frames, strict=True))


def _with_times(frames: Frames, form: FormChoice, stamp_width: int) -> tuple[Frames, int]:
    """Return the frames with the times that a form prints, and the number of characters of a time."""
    if form in {FormChoice.log, FormChoice.ta} or not len(frames):
        return frames, stamp_width
    if form is FormChoice.tz:
        times = frames.time - frames.time[0]
    else:
        times = np.diff(frames.time, prepend=frames.time[0])
    return replace(frames, time=np.maximum(times, 0.0)), RELATIVE_WIDTH


def _write(lines: Iterator[str]) -> None:
    while block := list(itertools.islice(lines, _AT_ONCE)):
        sys.stdout.write("\n".join(block) + "\n")
    sys.stdout.flush()


def _dump_bus(
    frames: Generator[Frame], form: FormChoice, decoder: FrameDecoder, decode: bool, rates: bool
) -> None:
    """Print frames as they come, or their rates at the end; Ctrl-C and SIGTERM end it in good order."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    seen: list[Frame] = []
    indent, since = False, 0.0
    with contextlib.suppress(KeyboardInterrupt), contextlib.closing(frames):
        for frame in frames:
            if rates:
                seen.append(frame)
                continue
            indent = indent or bool(frame.flags & EXTENDED)
            words = f"  ; {decoder(frame)}" if decode else ""
            if form in {FormChoice.td, FormChoice.tz}:
                since = since or frame.time
                shown = frame._replace(time=max(0.0, frame.time - since))
                since = frame.time if form is FormChoice.td else since
                line = format_frame(shown, "ta", indent=indent, stamp_width=RELATIVE_WIDTH)
            else:
                line = format_frame(frame, form.layout, indent=indent)
            sys.stdout.write(line + words + "\n")
            sys.stdout.flush()
    if rates:
        _write(rate_lines(frames_of(seen), decoder))


def _live(url: str, wanted: FrameFilter, count: int | None, seconds: float | None) -> Generator[Frame]:
    """Yield the wanted frames of a bus until it is enough."""
    from omnimate.driver.bus import open_bus

    end = None if seconds is None else time.monotonic() + seconds
    start: float | None = None
    with open_bus(url) as bus:
        while (count is None or count > 0) and (end is None or time.monotonic() < end):
            message = bus.recv(_POLL if end is None else max(0.0, min(_POLL, end - time.monotonic())))
            if message is None:
                continue
            frame = frame_of_message(message)
            if isinstance(frame, str):
                warn(f"a frame was left out: {frame}")
                continue
            start = frame.time if start is None else start
            if wanted != FrameFilter() and not wanted.wants(frames_of([frame]), start)[0]:
                continue
            count = None if count is None else count - 1
            yield frame
