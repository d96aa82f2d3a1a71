"""Writers of message files: MCAP, and ROS 2 bags (sqlite3)."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import contextmanager
from typing import TYPE_CHECKING, Literal

from omnimate.files.errors import ExportError
from omnimate.files.exporters.messages import Message

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from rosbags.interfaces import Connection
    from rosbags.typesys.store import Typestore

_BAG_VERSION: Literal[9] = 9  # of metadata.yaml, ROS 2 Iron and later; older ones read it too

WriteMessage = Callable[[Message], None]  # called in order of time


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
