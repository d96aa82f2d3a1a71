"""Drives and frames as ROS 2 messages, serialised as CDR: what Foxglove, PlotJuggler, rviz and rerun know.

Only this file and `omnimate.files.exporters.sinks` use the optional libraries `rosbags` and `mcap`.
"""

from __future__ import annotations

import heapq
import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from omnimate.files.exporters.errors import ExportError
from omnimate.files.logs.formats.stamps import NANOSECOND, nanoseconds
from omnimate.files.logs.frames import ERROR, EXTENDED, FD, REMOTE
from omnimate.vehicle.parameters import JOINTS

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence
    from pathlib import Path as FilePath

    from rosbags.typesys.store import Typestore

    from omnimate.files.exporters.drive import Drive, Path
    from omnimate.files.logs.bus_events import BusEvent
    from omnimate.files.logs.frames import Frame
    from omnimate.vehicle.parameters import Channel
    from omnimate.vehicle.recording import Recording
    from omnimate.vehicle.se2 import Array

WORLD = "odom"  # frame in which all poses stand
LAST = 2**31 - 1  # [s] of builtin_interfaces/msg/Time
INFO, WARN = 20, 30  # levels of rcl_interfaces/msg/Log
# Of can_msgs (ros_canopen) and ros2_socketcan_msgs, which the library does not bring.
CAN_FRAME, CAN_FD_FRAME = "can_msgs/msg/Frame", "ros2_socketcan_msgs/msg/FdFrame"
_DEFINITIONS = {
    CAN_FRAME: (
        "std_msgs/Header header\nuint32 id\nbool is_rtr\nbool is_extended\nbool is_error\n"
        "uint8 dlc\nuint8[8] data\n"
    ),
    CAN_FD_FRAME: (
        "std_msgs/Header header\nuint32 id\nbool is_extended\nbool is_error\nuint8 len\nuint8[<=64] data\n"
    ),
}
_X, _Y, _YAW = 0, 7, 35  # on the diagonal of ROS's 6 x 6 covariance


class Message(NamedTuple):
    """A message as it stands in a file.

    Attributes:
        topic: Topic of the message.
        kind: Type, such as `nav_msgs/msg/Odometry`.
        stamp: Time of the message [ns].
        data: The message as CDR.
    """

    topic: str
    kind: str
    stamp: int
    data: bytes


class Messages:
    """Makes ROS 2 messages.

    Attributes:
        typestore: The types of ROS 2, and those of CAN frames.
    """

    def __init__(self, target: FilePath) -> None:
        """Load the types.

        Args:
            target: What is written, for the error.
        """
        from rosbags.typesys import Stores, get_types_from_msg, get_typestore  # noqa: PLC0415 -- an extra

        self._target = target
        self.typestore: Typestore = get_typestore(Stores.ROS2_HUMBLE)
        for kind, text in _DEFINITIONS.items():
            self.typestore.register(get_types_from_msg(text, kind))
        self._types: Mapping[str, Any] = self.typestore.types
        self._no_covariance = np.zeros(36)
        self._none = np.zeros(0)

    def of_drive(self, drive: Drive) -> Iterator[Message]:
        """Yield the joints, commands, paths, poses and events of a drive, in order of time."""
        sources = [self._joints(drive.recording), self._commands(drive.recording), self._events(drive.events)]
        sources += [self._path(path) for path in drive.paths]
        sources += [self._transforms(drive.paths), self._measured(drive)]
        return heapq.merge(*sources, key=lambda message: message.stamp)

    def of_frame(self, frame: Frame) -> Message:
        """Return a frame as a message on the topic of its interface."""
        stamp = nanoseconds(frame.time)
        is_error, is_extended = bool(frame.flags & ERROR), bool(frame.flags & EXTENDED)
        length = len(frame.data) if frame.length is None else frame.length
        header = self._header(stamp, frame.channel)
        if frame.flags & FD:
            data = np.frombuffer(frame.data, np.uint8)
            content = self._types[CAN_FD_FRAME](header, frame.can_id, is_extended, is_error, length, data)
            return self._message(f"/can_fd/{_topic(frame.channel)}", CAN_FD_FRAME, stamp, content)
        data = np.frombuffer(frame.data.ljust(8, b"\0"), np.uint8)
        is_remote = bool(frame.flags & REMOTE)
        content = self._types[CAN_FRAME](header, frame.can_id, is_remote, is_extended, is_error, length, data)
        return self._message(f"/can/{_topic(frame.channel)}", CAN_FRAME, stamp, content)

    def of_event(self, event: BusEvent) -> Message:
        """Return an event as a message of a log."""
        stamp = nanoseconds(event.time)
        level = WARN if event.is_problem else INFO
        name = "bus" if event.node is None else f"node {event.node}"
        time = self._time(stamp)
        content = self._types["rcl_interfaces/msg/Log"](time, level, name, event.what, "", "", 0)
        return self._message("/events", "rcl_interfaces/msg/Log", stamp, content)

    def _events(self, events: Iterable[BusEvent]) -> Iterator[Message]:
        yield from map(self.of_event, events)

    def _joints(self, recording: Recording) -> Iterator[Message]:
        """Yield the positions of wheels, joints and link that were read in each sample [rad, m]."""
        names = recording.vehicle.channels
        positions = np.column_stack([channel_values(recording, name) for name in names])
        for time, row, present in zip(recording.time.tolist(), positions, recording.present, strict=True):
            there = [name for name, is_there in zip(names, present.tolist(), strict=True) if is_there]
            if there:
                yield self._joint_state("/joint_states", time, there, position=row[present])

    def _commands(self, recording: Recording) -> Iterator[Message]:
        """Yield the wheel speeds that were commanded before each sample [rad/s]."""
        names = [str(wheel) for wheel in recording.vehicle.wheels]
        commands = np.zeros((0, len(names))) if recording.commands is None else recording.commands
        for time, row in zip(recording.time.tolist(), commands, strict=False):
            known = ~np.isnan(row)
            if known.any():
                there = [name for name, is_there in zip(names, known.tolist(), strict=True) if is_there]
                yield self._joint_state("/commands", time, there, velocity=row[known])

    def _joint_state(
        self,
        topic: str,
        time: float,
        names: Sequence[str],
        *,
        position: Array | None = None,
        velocity: Array | None = None,
    ) -> Message:
        stamp = nanoseconds(time)
        content = self._types["sensor_msgs/msg/JointState"](
            self._header(stamp, ""),
            names,
            self._none if position is None else position,
            self._none if velocity is None else velocity,
            self._none,
        )
        return self._message(topic, "sensor_msgs/msg/JointState", stamp, content)

    def _path(self, path: Path) -> Iterator[Message]:
        """Yield the poses of a truck with their speeds."""
        kind, types = "nav_msgs/msg/Odometry", self._types
        vector, twist = types["geometry_msgs/msg/Vector3"], types["geometry_msgs/msg/Twist"]
        still = vector(0.0, 0.0, 0.0)
        for time, pose, (speed, turning) in zip(
            path.time.tolist(), path.pose.tolist(), speeds(path.time, path.pose).tolist(), strict=True
        ):
            if math.isnan(pose[0]):
                continue
            stamp = nanoseconds(time)
            motion = twist(vector(speed, 0.0, 0.0), vector(0.0, 0.0, turning) if turning else still)
            content = types[kind](
                self._header(stamp, WORLD),
                _body(path),
                types["geometry_msgs/msg/PoseWithCovariance"](self._pose(pose), self._no_covariance),
                types["geometry_msgs/msg/TwistWithCovariance"](motion, self._no_covariance),
            )
            yield self._message(f"/{path.method}/{path.truck}", kind, stamp, content)

    def _transforms(self, paths: Sequence[Path]) -> Iterator[Message]:
        """Yield where the frames of all trucks are at each sample."""
        kind, types = "tf2_msgs/msg/TFMessage", self._types
        vector, transform = types["geometry_msgs/msg/Vector3"], types["geometry_msgs/msg/Transform"]
        names = [_body(path) for path in paths]
        poses = zip(*(path.pose.tolist() for path in paths), strict=True)
        for time, places in zip(paths[0].time.tolist(), poses, strict=True):
            stamp = nanoseconds(time)
            header = self._header(stamp, WORLD)
            transforms = [
                types["geometry_msgs/msg/TransformStamped"](
                    header, name, transform(vector(x, y, 0.0), self._turn(theta))
                )
                for name, (x, y, theta) in zip(names, places, strict=True)
                if not math.isnan(x)
            ]
            yield self._message("/tf", kind, stamp, types[kind](transforms))

    def _measured(self, drive: Drive) -> Iterator[Message]:
        """Yield the absolute poses, and as points those whose heading was not measured."""
        poses, types = drive.recording.poses, self._types
        if poses is None:
            return
        for time, body, pose, sigma in zip(
            poses.time.tolist(), poses.body.tolist(), poses.pose.tolist(), poses.sigma.tolist(), strict=True
        ):
            stamp = nanoseconds(time)
            header = self._header(stamp, WORLD)
            if math.isnan(pose[0]) or math.isnan(pose[1]):
                continue
            if math.isnan(pose[2]):
                kind = "geometry_msgs/msg/PointStamped"
                content = types[kind](header, types["geometry_msgs/msg/Point"](pose[0], pose[1], 0.0))
                yield self._message(f"/positions/{body}", kind, stamp, content)
                continue
            kind = "geometry_msgs/msg/PoseWithCovarianceStamped"
            covariance = np.zeros(36)
            for place, deviation in zip((_X, _Y, _YAW), sigma, strict=True):
                covariance[place] = 0.0 if math.isnan(deviation) else deviation**2
            known = types["geometry_msgs/msg/PoseWithCovariance"](self._pose(pose), covariance)
            yield self._message(f"/poses/{body}", kind, stamp, types[kind](header, known))

    def _message(self, topic: str, kind: str, stamp: int, content: object) -> Message:
        return Message(topic, kind, stamp, bytes(self.typestore.serialize_cdr(content, kind)))

    def _header(self, stamp: int, frame: str) -> object:
        header: object = self._types["std_msgs/msg/Header"](self._time(stamp), frame)
        return header

    def _time(self, stamp: int) -> object:
        whole, rest = divmod(stamp, NANOSECOND)
        if whole > LAST:
            raise ExportError(self._target, f"a time of {whole} s; ROS 2 counts up to {LAST} s, in 2038")
        time: object = self._types["builtin_interfaces/msg/Time"](whole, rest)
        return time

    def _pose(self, pose: list[float]) -> object:
        x, y, theta = pose
        place: object = self._types["geometry_msgs/msg/Point"](x, y, 0.0)
        whole: object = self._types["geometry_msgs/msg/Pose"](place, self._turn(theta))
        return whole

    def _turn(self, theta: float) -> object:
        """Return a heading as a quaternion."""
        half = 0.5 * theta
        turn: object = self._types["geometry_msgs/msg/Quaternion"](0.0, 0.0, math.sin(half), math.cos(half))
        return turn


def channel_values(recording: Recording, channel: Channel) -> Array:
    """Return the angle of a wheel or joint [rad] or the length of the link [m] at each sample, `(N,)`."""
    if channel == "link":
        return recording.link_length()
    return recording.joint_angle(channel) if channel in JOINTS else recording.wheel_angle(channel)


def speeds(time: Array, pose: Array) -> Array:
    """Return speed ahead [m/s] and turning [rad/s] since the sample before, `(N, 2)`; zero at the first."""
    step, passed = np.diff(pose, axis=0), np.diff(time)
    turned = (step[:, 2] + math.pi) % (2.0 * math.pi) - math.pi
    middle = pose[:-1, 2] + 0.5 * turned
    ahead = step[:, 0] * np.cos(middle) + step[:, 1] * np.sin(middle)
    rates = np.zeros((len(pose), 2))
    moving = passed > 0.0
    rates[1:][moving] = np.column_stack((ahead, turned))[moving] / passed[moving, None]
    return np.nan_to_num(rates)


def _body(path: Path) -> str:
    """Return the name of a truck's frame, `a` by odometry and `a_ipec` by IPEC."""
    return f"truck_{path.truck}" + ("_ipec" if path.method == "ipec" else "")


def _topic(channel: str) -> str:
    """Return an interface's name as a part of a topic."""
    return "".join(letter if letter.isascii() and letter.isalnum() else "_" for letter in channel)
