"""Topics and messages of ROS 1 bags, ROS 2 bags (sqlite3, MCAP) and single MCAP files.

Only this file uses the library `rosbags`, which is an optional dependency.
"""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from omnimate.files.errors import SourceError

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterator

    from rosbags.highlevel import AnyReader

_PROGRESS_INTERVAL = 500  # messages between two reports of progress
_NAMING_MESSAGES = 300  # messages of a topic in which names of joints and frames are collected
_NAMED = ("sensor_msgs/msg/JointState", "tf2_msgs/msg/TFMessage", "tf/msg/tfMessage")


class Message(NamedTuple):
    """One message.

    The type is without `msg/`, such as `sensor_msgs/JointState`; the time is that at which the bag received
    it [ns].
    """

    topic: str
    kind: str
    time: int
    content: Any


@dataclass(frozen=True, slots=True)
class Topic:
    """One topic of a bag.

    The type is without `msg/`; parts are names of joints or of child frames, where the messages have them.
    """

    name: str
    kind: str
    count: int
    parts: tuple[str, ...] = ()


def topics_of(path: Path | str) -> tuple[Topic, ...]:
    """Return the topics of a bag by their names.

    Raises:
        SourceError: The bag cannot be read.
    """
    with _open_bag(Path(path)) as reader:
        topics = []
        for name, info in sorted(reader.topics.items()):
            kind = info.msgtype or "several types"
            parts = _parts(reader, name) if kind in _NAMED else ()
            topics.append(Topic(name, _short(kind), info.msgcount, parts))
        return tuple(topics)


def messages_of(
    path: Path | str, topics: Collection[str], progress: Callable[[int, int], None] | None = None
) -> Iterator[Message]:
    """Yield the messages of some topics in the order in which the bag received them.

    Raises:
        SourceError: The bag cannot be read, is empty, or lacks a topic.
    """
    with _open_bag(Path(path)) as reader:
        _check(reader, Path(path), topics)
        wanted = [connection for connection in reader.connections if connection.topic in topics]
        total = sum(connection.msgcount for connection in wanted)
        for number, (connection, time, raw) in enumerate(reader.messages(wanted)):
            if progress is not None and number % _PROGRESS_INTERVAL == 0:
                progress(number, total)
            content = reader.deserialize(raw, connection.msgtype)
            yield Message(connection.topic, _short(connection.msgtype), time, content)


def _check(reader: AnyReader, path: Path, topics: Collection[str]) -> None:
    if not reader.message_count:
        raise SourceError(path, "the bag is empty")
    for topic in topics:
        if topic not in reader.topics:
            raise SourceError(path, f"no topic {topic}; the bag has {', '.join(sorted(reader.topics))}")
        if not reader.topics[topic].msgcount:
            raise SourceError(path, f"topic {topic} has no message")


def _parts(reader: AnyReader, topic: str) -> tuple[str, ...]:
    """Return the names of joints or child frames in a topic's first messages."""
    names: dict[str, None] = {}
    wanted = [connection for connection in reader.connections if connection.topic == topic]
    for number, (connection, _, raw) in enumerate(reader.messages(wanted)):
        content: Any = reader.deserialize(raw, connection.msgtype)
        names |= dict.fromkeys(
            [transform.child_frame_id for transform in content.transforms]
            if hasattr(content, "transforms")
            else content.name
        )
        if number == _NAMING_MESSAGES:
            break
    return tuple(names)


@contextmanager
def _open_bag(path: Path) -> Iterator[AnyReader]:
    """Open a bag; every error of the library about its content becomes a SourceError."""
    try:
        from rosbags.highlevel import AnyReader, AnyReaderError  # noqa: PLC0415 - an extra; few need it
        from rosbags.typesys import Stores, get_typestore  # noqa: PLC0415 - likewise
    except ImportError as error:
        raise SourceError(path, "bags need the library rosbags: pip install 'omnimate[rosbag]'") from error
    paths = _files(path)
    try:
        with AnyReader(paths, default_typestore=get_typestore(Stores.LATEST)) as reader:
            yield reader
    except SourceError:
        raise
    except AnyReaderError as error:
        raise SourceError(path, f"the bag cannot be read: {error}") from error
    except Exception as error:
        if not type(error).__module__.startswith(_LIBRARIES) and not isinstance(error, _DAMAGE):
            raise
        raise SourceError(path, f"the bag is damaged: {type(error).__name__}: {error}") from error


_LIBRARIES = ("rosbags", "sqlite3", "apsw", "lz4", "zstandard", "backports", "ruamel", "struct", "_struct")
# OverflowError and MemoryError: a size that is damaged, of which the library reads as many bytes.
_DAMAGE = (
    OSError, EOFError, ValueError, KeyError, IndexError, AssertionError, OverflowError, MemoryError,
)  # fmt: skip


def _files(path: Path) -> list[Path]:
    """Return the paths for the library: a file, a ROS 2 folder, or the ROS 1 bags in a folder."""
    if not path.exists():
        raise SourceError(path, "no such file or folder")
    if path.is_file():
        if path.suffix not in {".bag", ".mcap", ".db3"}:
            raise SourceError(path, "no bag; expected .bag, .mcap, .db3, or the folder of a ROS 2 bag")
        return [path]
    if (path / "metadata.yaml").exists():
        return [path]
    inside = sorted(path.glob("*.bag")) or sorted([*path.glob("*.mcap"), *path.glob("*.db3")])
    if not inside:
        raise SourceError(path, "no bag in it; expected metadata.yaml of a ROS 2 bag, *.bag, *.mcap or *.db3")
    return inside


def _short(kind: str) -> str:
    return kind.replace("/msg/", "/")
