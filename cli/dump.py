"""`omnimate dump`: a log or a live bus as candump prints it, in words where asked."""

from __future__ import annotations

import contextlib
import itertools
import signal
import sys
import time
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from omnimate.cli.console import warn
from omnimate.logs.decoding import FrameDecoder
from omnimate.logs.folder import VEHICLE, log_path
from omnimate.logs.formats.candump_lines import format_frame, format_lines
from omnimate.logs.formats.python_can_logs import frame_of_message
from omnimate.logs.frames import EXTENDED, Frame, frames_of
from omnimate.logs.rates import rate_lines
from omnimate.logs.reading import read_log
from omnimate.vehicle.file import load_vehicle

if TYPE_CHECKING:
    from collections.abc import Generator, Iterator

    from omnimate.logs.formats.candump_lines import Form
    from omnimate.vehicle.parameters import VehicleParameters

_POLL = 0.2  # [s] after which a silent bus is asked again
_AT_ONCE = 1000  # lines of a log that are written together


class FormChoice(Enum):
    """How a line looks: `candump -L` or `candump -ta`."""

    log = "log"
    ta = "ta"


def dump(
    source: Annotated[
        Path | None, typer.Argument(help="Log file (candump, .asc, .blf, .trc; .gz too) or recording folder.")
    ] = None,
    bus: Annotated[str | None, typer.Option(help="Read this bus instead, such as socketcan://can0.")] = None,
    form: Annotated[
        FormChoice, typer.Option(help="Lines as of candump -L, or as of candump -ta.")
    ] = FormChoice.log,
    decode: Annotated[
        bool, typer.Option("--decode", help="Say behind each line what the frame means.")
    ] = False,
    vehicle: Annotated[
        Path | None, typer.Option(help="vehicle.toml whose channels to name; a recording folder has its own.")
    ] = None,
    rates: Annotated[
        bool, typer.Option("--rates", help="Print the rate of each identifier instead.")
    ] = False,
    count: Annotated[int | None, typer.Option(min=1, help="End after so many frames.")] = None,
    seconds: Annotated[float | None, typer.Option(min=0.0, help="End a live bus after so long [s].")] = None,
) -> None:
    """Print the frames of a log or of a live bus."""
    if (source is None) == (bus is None):
        raise typer.BadParameter("give either a log file or --bus URL")
    decoder = FrameDecoder(_vehicle(vehicle, source))
    if bus is not None:
        _dump_bus(_live(bus, count, seconds), form.value, decoder, decode, rates)
    elif source is not None and not _dump_log(source, form.value, decoder, decode, rates, count):
        raise typer.Exit(1)


def _vehicle(path: Path | None, source: Path | None) -> VehicleParameters | None:
    """Return the robot that was asked for, or the one of a recording folder."""
    if path is None and source is not None and source.is_dir():
        path = source / VEHICLE
    return load_vehicle(path) if path else None


def _dump_log(
    source: Path, form: Form, decoder: FrameDecoder, decode: bool, rates: bool, count: int | None
) -> bool:
    """Print a log; say whether all of it could be read."""
    log = read_log(log_path(source) if source.is_dir() else source)
    frames = log.frames.select(slice(count))
    lines = format_lines(frames, form, log.stamp_width)
    if decode:
        lines = (f"{line}  ; {decoder(frame)}" for line, frame in zip(lines, frames, strict=True))
    _write(rate_lines(frames, decoder) if rates else lines)
    for problem in log.problems():
        warn(problem)
    return log.is_whole


def _write(lines: Iterator[str]) -> None:
    while block := list(itertools.islice(lines, _AT_ONCE)):
        sys.stdout.write("\n".join(block) + "\n")
    sys.stdout.flush()


def _dump_bus(frames: Generator[Frame], form: Form, decoder: FrameDecoder, decode: bool, rates: bool) -> None:
    """Print frames as they come, or their rates at the end; Ctrl-C and SIGTERM end it in good order."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    seen: list[Frame] = []
    indent = False
    with contextlib.suppress(KeyboardInterrupt), contextlib.closing(frames):
        for frame in frames:
            if rates:
                seen.append(frame)
                continue
            indent = indent or bool(frame.flags & EXTENDED)
            words = f"  ; {decoder(frame)}" if decode else ""
            sys.stdout.write(format_frame(frame, form, indent=indent) + words + "\n")
            sys.stdout.flush()
    if rates:
        _write(rate_lines(frames_of(seen), decoder))


def _live(url: str, count: int | None, seconds: float | None) -> Generator[Frame]:
    """Yield the frames of a bus until it is enough."""
    from omnimate.driver.bus import open_bus

    end = None if seconds is None else time.monotonic() + seconds
    with open_bus(url) as bus:
        while (count is None or count > 0) and (end is None or time.monotonic() < end):
            message = bus.recv(_POLL if end is None else max(0.0, min(_POLL, end - time.monotonic())))
            if message is None:
                continue
            frame = frame_of_message(message)
            if isinstance(frame, str):
                warn(f"a frame was left out: {frame}")
                continue
            count = None if count is None else count - 1
            yield frame
