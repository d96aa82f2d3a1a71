"""Export of drives and logs in the format of a file's suffix."""

from __future__ import annotations

import heapq
import importlib.util
from collections import Counter
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

from omnimate.files.errors import ExportError
from omnimate.files.exporters.messages import Messages
from omnimate.files.exporters.parquet import write_frames, write_parquet
from omnimate.files.exporters.tum import write_tum
from omnimate.files.logs.blocks import REPORT_EVERY
from omnimate.files.logs.bus_events import BusEvents
from omnimate.files.logs.writing import SUFFIXES as LOG_SUFFIXES
from omnimate.files.logs.writing import log_suffix, open_writer, written_whole

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator
    from pathlib import Path

    from rosbags.interfaces import Connection
    from rosbags.typesys.store import Typestore

    from omnimate.files.exporters.drive import Drive
    from omnimate.files.exporters.messages import Message
    from omnimate.files.logs.blocks import LogStream
    from omnimate.files.logs.frames import Frame

    WriteMessage = Callable[[Message], None]  # called in order of time

MCAP, PARQUET, TUM, BAG = ".mcap", ".parquet", ".tum", ""
_BAG_VERSION: Literal[9] = 9  # of metadata.yaml, ROS 2 Iron and later; older ones read it too
DRIVE_SUFFIXES = (MCAP, PARQUET, TUM, BAG)  # of formats that hold a drive
EXTRAS = {  # format: its extra, and the modules that it installs
    MCAP: ("mcap", ("rosbags.typesys", "mcap.writer")),
    BAG: ("rosbag", ("rosbags.typesys",)),
    PARQUET: ("parquet", ("pyarrow",)),
}


@dataclass(slots=True)
class Exported:
    """Result of an export.

    `files` has the folder of a bag; `left_out` counts the frames that the format cannot hold, by the reason.
    """

    files: tuple[Path, ...] = ()
    frames: int = 0
    left_out: Counter[str] = field(default_factory=Counter)


def suffix_of(target: Path) -> str:
    """Return the suffix that determines the format of an output file or folder, with its libraries checked.

    Raises:
        ExportError: No format has this suffix, or a library of an extra is not installed.
    """
    suffix = log_suffix(target) or target.suffix.lower()
    if suffix not in {*LOG_SUFFIXES, *DRIVE_SUFFIXES}:
        known = ", ".join(sorted({*LOG_SUFFIXES, MCAP, PARQUET, TUM}))
        raise ExportError(target, f"no format {suffix}; expected {known}, or no suffix for a ROS 2 bag")
    extra, modules = EXTRAS.get(suffix, ("", ()))
    for module in modules:
        if not _is_installed(module):
            library = module.partition(".")[0]
            problem = f"this format needs the library {library}: pip install 'omnimate[{extra}]'"
            raise ExportError(target, problem)
    return suffix


def _is_installed(module: str) -> bool:
    try:
        return importlib.util.find_spec(module) is not None
    except ModuleNotFoundError:  # the package around it
        return False


def export_frames(log: LogStream, target: Path, progress: Callable[[int, int], None]) -> Exported:
    """Write a log frame by frame; MCAP files and bags also get the events in it.

    The suffix of `target` determines the format; `progress` is called with the bytes read and their total.

    Raises:
        ExportError: The format holds no frames, or a requirement is missing.
        LogError: The log cannot be read, or the file cannot be written.
    """
    suffix = suffix_of(target)
    if suffix == TUM:
        problem = "TUM holds trajectories; give --vehicle, or a recording folder, so that there is one"
        raise ExportError(target, problem)
    frames = log.with_progress(progress)
    if suffix in {MCAP, BAG}:
        return _export_messages(target, suffix, lambda make: _messages_of(frames, make))
    done = Exported((target,))
    with written_whole(target) as partial:
        if suffix == PARQUET:
            write_frames(frames, partial)
            done.frames = log.frames
        else:
            with closing(open_writer(partial, suffix)) as writer:
                for frame in frames:
                    done.left_out[writer.write_frame(frame) or ""] += 1
            done.frames = done.left_out.pop("", 0)
    return done


def export_drive(
    drive: Drive, target: Path, progress: Callable[[int, int], None], log: LogStream | None = None
) -> Exported:
    """Write a drive: samples, odometry, IPEC, measured poses and events, as far as the format holds them.

    The suffix of `target` determines the format; `progress` is called with the amount written and the total,
    and `log` is one whose frames are written too.

    Raises:
        ExportError: The format holds no drive, or a requirement is missing.
        LogError: The log cannot be read, or the file cannot be written.
    """
    suffix = suffix_of(target)
    if suffix in {MCAP, BAG}:
        frames = () if log is None else log
        first, last = (1e9 * float(drive.recording.time[place]) for place in (0, -1))

        def merged(make: Messages) -> Iterator[Message]:
            sources = (make.of_drive(drive), map(make.of_frame, frames))
            for number, message in enumerate(heapq.merge(*sources, key=lambda message: message.stamp)):
                if number % REPORT_EVERY == 0:
                    progress(int(message.stamp - first), int(last - first))
                yield message

        return _export_messages(target, suffix, merged)
    if suffix == PARQUET:
        done = Exported(write_parquet(drive, target))
        if log is not None:
            frame_files = export_frames(log, target.with_name(f"{target.stem}-frames{PARQUET}"), progress)
            done = Exported((*done.files, *frame_files.files), frame_files.frames)
        return done
    if suffix == TUM and log is None:
        return Exported(write_tum(drive, target))
    problem = (
        f"{suffix} holds no frames; leave --frames out" if suffix == TUM else f"{suffix} holds frames only"
    )
    raise ExportError(target, problem)


def _messages_of(frames: Iterable[Frame], make: Messages) -> Iterator[Message]:
    events = BusEvents()
    for frame in frames:
        yield make.of_frame(frame)
        event = events.take(frame)
        if event is not None:
            yield make.of_event(event)


def _export_messages(
    target: Path, suffix: str, messages: Callable[[Messages], Iterator[Message]]
) -> Exported:
    make = Messages(target)
    done = Exported((target,))
    with ExitStack() as stack:
        if suffix == BAG:
            write = stack.enter_context(bag_sink(target, make.typestore))
        else:
            partial = stack.enter_context(written_whole(target))
            write = stack.enter_context(mcap_sink(partial, make.typestore))
        for message in messages(make):
            write(message)
            done.frames += message.topic.startswith("/can")
    return done


@contextmanager
def mcap_sink(path: Path, typestore: Typestore) -> Iterator[WriteMessage]:
    """Open an MCAP file of profile `ros2`; yield the function that writes a message."""
    from mcap.writer import Writer  # noqa: PLC0415 -- an extra; few need it

    schemas: dict[str, int] = {}
    channels: dict[str, int] = {}
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start("ros2", "omnimate")

        def write(message: Message) -> None:
            topic, kind = message.topic, message.kind
            if kind not in schemas:
                text, _ = typestore.generate_msgdef(kind, ros_version=2)
                schemas[kind] = writer.register_schema(kind, "ros2msg", text.encode())
            if topic not in channels:
                channels[topic] = writer.register_channel(topic, "cdr", schemas[kind])
            writer.add_message(channels[topic], message.stamp, message.data, message.stamp)

        yield write
        writer.finish()  # type: ignore[no-untyped-call]  # the library's


@contextmanager
def bag_sink(folder: Path, typestore: Typestore) -> Iterator[WriteMessage]:
    """Open a ROS 2 bag; yield the function that writes a message.

    Raises:
        ExportError: The folder exists.
    """
    from rosbags.rosbag2 import Writer  # noqa: PLC0415 -- an extra; few need it

    if folder.exists():
        raise ExportError(folder, "it exists; choose another folder for the bag")
    topics: dict[str, Connection] = {}
    with Writer(folder, version=_BAG_VERSION) as writer:

        def write(message: Message) -> None:
            topic = message.topic
            if topic not in topics:
                topics[topic] = writer.add_connection(topic, message.kind, typestore=typestore)
            writer.write(topics[topic], message.stamp, message.data)

        yield write
