"""`omnimate listen`: what an unknown bus is, by listening alone; a DBC file and a draft of `vehicle.toml`."""

from __future__ import annotations

import contextlib
import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from omnimate.cli.console import progress_bar, say, warn
from omnimate.cli.errors import CallError
from omnimate.cli.loading import frames_on_bus, log_of, report_problems
from omnimate.cli.options import OptionalLogSource, existing_log
from omnimate.files.logs.frames import Frames, frames_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from omnimate.files.logs.frames import Frame
    from omnimate.files.logs.signals import Signal
    from omnimate.listen.draft import Turn
    from omnimate.listen.learning import Findings
    from omnimate.listen.meanings import Meaning

DRAFT = "vehicle.toml"


def listen(
    source: OptionalLogSource = None,
    bus: Annotated[str | None, typer.Option(help="Listen to this bus, such as socketcan://can0.")] = None,
    log: Annotated[Path | None, typer.Option(hidden=True, parser=existing_log)] = None,
    seconds: Annotated[
        float, typer.Option(help="How long to listen [s]; Ctrl-C ends it earlier.", min=1.0)
    ] = 60.0,
    write: Annotated[
        Path | None,
        typer.Option(help="Folder for bus.dbc, vehicle.toml, report.txt and a picture of each message."),
    ] = None,
    turn: Annotated[
        Literal["left", "right"] | None,
        typer.Option(help="Direction of the first clear turn; it distinguishes left from right."),
    ] = None,
    channel: Annotated[
        str | None, typer.Option(help="Interface in a log of several, such as can1; else the busiest.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the findings as JSON.")] = False,
    reasons: Annotated[
        bool, typer.Option("--reasons", help="Say of each signal how it was decided; report.txt always does.")
    ] = False,
) -> None:
    """Find what an unknown bus carries: nodes, PDOs, signals, wheels. Sends nothing."""
    from omnimate.listen.learning import learn_bus
    from omnimate.listen.meanings import meanings_of
    from omnimate.listen.report import findings_as_json, report_lines

    source = source or log  # scripts of version 0.2 have --log
    if (bus is None) == (source is None):
        raise CallError("listen takes either a bus (--bus URL) or a log; give one of them")
    if write is not None and (write / DRAFT).exists():  # said before an hour of listening, not after it
        raise CallError(f"{write / DRAFT}: exists already; name a new folder, or remove it")
    frames = _read_frames(source) if source is not None else _received(str(bus), seconds)
    frames = _of_channel(frames, channel)
    known = _known(frames)
    with progress_bar("learning signals") as progress:
        findings = learn_bus(frames, known, progress)
    meanings = meanings_of(findings)
    if as_json:
        say(json.dumps(findings_as_json(findings, meanings), indent=1))
    else:
        for line in report_lines(findings, meanings, reasons=reasons):
            say(line)
    if write is not None:
        _write(write, findings, meanings, bus, turn)
        if not as_json:
            say(f"written: {write}")


def _read_frames(path: Path) -> Frames:
    from omnimate.files.logs.blocks import read_log

    log = read_log(log_of(path))
    report_problems(log.blocks)
    return log.frames


def _received(url: str, seconds: float) -> Frames:
    """Return the frames of a bus, received for so many seconds or until Ctrl-C."""
    received: list[Frame] = []
    with progress_bar("listening") as progress, contextlib.suppress(KeyboardInterrupt):
        for frame in frames_on_bus(url, seconds, progress):
            received.append(frame)  # noqa: PERF402  # Ctrl-C keeps the frames so far
    if not received:
        raise CallError(f"{url}: no frame was received; check the bit rate and the power")
    return frames_of(received)


def _of_channel(frames: Frames, channel: str | None) -> Frames:
    """Return the frames of one interface."""
    import numpy as np

    if channel is not None and channel not in frames.channels:
        raise CallError(f"--channel {channel}: expected one of {', '.join(frames.channels)}")
    if len(frames.channels) == 1:
        return frames
    counts = np.bincount(frames.channel, minlength=len(frames.channels))
    number = int(counts.argmax()) if channel is None else frames.channels.index(channel)
    if channel is None:
        others = ", ".join(name for name in frames.channels if name != frames.channels[number])
        warn(f"only {frames.channels[number]} is read, the busiest interface; --channel reads {others}")
    return frames.select(frames.channel == number)


def _known(frames: Frames) -> Mapping[int, Sequence[Signal]]:
    """Return the fields of PDOs that SDO traffic in the log shows, by COB-ID."""
    from omnimate.driver.canopen.mapped_signals import mapped_signals
    from omnimate.files.logs.seen_mapping import seen_objects

    seen = seen_objects(frames)
    return mapped_signals(seen, {}) if seen else {}


def _write(
    folder: Path, findings: Findings, meanings: dict[str, Meaning], bus: str | None, turn: Turn | None
) -> None:
    from omnimate.driver.bus.adapters import BusUrl
    from omnimate.figures.signals import plot_signals
    from omnimate.listen.dbc import learned_dbc
    from omnimate.listen.draft import draft_vehicle
    from omnimate.listen.report import report_lines
    from omnimate.vehicle.atomic import write_text

    folder.mkdir(parents=True, exist_ok=True)
    bitrate = None if bus is None else BusUrl.of(bus).bitrate
    write_text(folder / "bus.dbc", learned_dbc(findings, meanings))
    write_text(folder / "report.txt", "\n".join([*report_lines(findings, meanings), ""]))
    write_text(folder / DRAFT, draft_vehicle(findings, bitrate, turn))
    with progress_bar("drawing messages") as progress:
        for number, learned in enumerate(findings.messages):
            moving = [signal for signal in learned.signals if signal.kind != "constant"]
            if moving:
                rows = [(meanings[s.label].name, s.time - findings.start, s.values()) for s in moving]
                plot_signals(
                    learned.message.name, rows, folder / f"{learned.signals[0].label.partition('.')[0]}.png"
                )
            progress(number + 1, len(findings.messages))
