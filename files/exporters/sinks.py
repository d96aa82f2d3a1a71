"""Files of messages: MCAP, and ROS 2 bags as `ros2 bag` writes them (sqlite3)."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING, Literal, Protocol

from omnimate.files.exporters.errors import ExportError

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from mcap.writer import Writer as McapWriter
    from rosbags.interfaces import Connection
    from rosbags.rosbag2 import Writer as BagWriter
    from rosbags.typesys.store import Typestore

    from omnimate.files.exporters.messages import Message

_BAG_VERSION: Literal[9] = 9  # of metadata.yaml, ROS 2 Iron and later; older ones read it too
_LIBRARY = "omnimate"


class Sink(Protocol):
    """Takes messages in order of time."""

    def write(self, message: Message) -> None:
        """Write a message."""
        ...


@contextmanager
def mcap_sink(path: Path, typestore: Typestore) -> Iterator[Sink]:
    """Open an MCAP file of the profile `ros2` for writing."""
    from mcap.writer import Writer  # noqa: PLC0415 -- an extra; few need it

    with path.open("wb") as file:
        writer = Writer(file)
        writer.start("ros2", _LIBRARY)
        yield _Mcap(writer, typestore)
        writer.finish()  # type: ignore[no-untyped-call]  # the library's


@contextmanager
def bag_sink(folder: Path, typestore: Typestore) -> Iterator[Sink]:
    """Open a ROS 2 bag for writing.

    Raises:
        ExportError: The folder exists.
    """
    from rosbags.rosbag2 import Writer  # noqa: PLC0415 -- an extra; few need it

    if folder.exists():
        raise ExportError(folder, "it exists; choose another folder for the bag")
    with Writer(folder, version=_BAG_VERSION) as writer:
        yield _Bag(writer, typestore)


class _Mcap:
    def __init__(self, writer: McapWriter, typestore: Typestore) -> None:
        self._writer = writer
        self._typestore = typestore
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}

    def write(self, message: Message) -> None:
        channel = self._channels.get(message.topic)
        if channel is None:
            schema = self._schema(message.kind)
            channel = self._channels[message.topic] = self._writer.register_channel(
                message.topic, "cdr", schema
            )
        self._writer.add_message(channel, message.stamp, message.data, message.stamp)

    def _schema(self, kind: str) -> int:
        if kind not in self._schemas:
            text, _ = self._typestore.generate_msgdef(kind, ros_version=2)
            self._schemas[kind] = self._writer.register_schema(kind, "ros2msg", text.encode())
        return self._schemas[kind]


class _Bag:
    def __init__(self, writer: BagWriter, typestore: Typestore) -> None:
        self._writer = writer
        self._typestore = typestore
        self._topics: dict[str, Connection] = {}

    def write(self, message: Message) -> None:
        topic = self._topics.get(message.topic)
        if topic is None:
            topic = self._topics[message.topic] = self._writer.add_connection(
                message.topic, message.kind, typestore=self._typestore
            )
        self._writer.write(topic, message.stamp, message.data)
