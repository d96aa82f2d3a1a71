"""Conversion of drives and frames to ROS 2 messages (CDR), for Foxglove, PlotJuggler, rviz and rerun.

Only this file and `omnimate.files.exporters.export` use the optional libraries `rosbags` and `mcap`.
"""

from __future__ import annotations

import heapq
import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from omnimate.files.errors import ExportError
from omnimate.files.logs.frames import ERROR, EXTENDED, FD, NANOSECOND, REMOTE, nanoseconds
from omnimate.vehicle.parameters import JOINTS

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path as FilePath

    from rosbags.typesys.store import Typestore

    from omnimate.files.exporters.drive import Drive, Path
    from omnimate.files.logs.bus_events import BusEvent
    from omnimate.files.logs.frames import Frame
    from omnimate.vehicle.parameters import Channel
    from omnimate.vehicle.recording import Recording
    from omnimate.vehicle.se2 import Array

WORLD = "odom"  # frame of all poses
MAX_TIME = 2**31 - 1  # [s] largest builtin_interfaces/msg/Time
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
    """A serialised message.

    The type is such as `nav_msgs/msg/Odometry`, the stamp in ns, the data CDR.
    """

    topic: str
    kind: str
    stamp: int
    data: bytes


class Messages:
    """Converts drives and frames to ROS 2 messages.

    Attributes:
        typestore: The types of ROS 2, and those of CAN frames.
    """

    def __init__(self, target: FilePath) -> None:
        """Load the types."""
        from rosbags.typesys import Stores, get_types_from_msg, get_typestore  # noqa: PLC0415 -- an extra

        self._target = target
        self.typestore: Typestore = get_typestore(Stores.ROS2_HUMBLE)
        for kind, text in _DEFINITIONS.items():
            self.typestore.register(get_types_from_msg(text, kind))

    def of_drive(self, drive: Drive) -> Iterator[Message]:
        """Yield the joints, commands, paths, poses and events of a drive, in order of time."""
        sources = [self._joints(drive.recording), self._commands(drive.recording)]
        sources.append(map(self.of_event, drive.events))
        sources += [self._path(path) for path in drive.paths]
        sources += [self._transforms(drive.paths), self._measured(drive)]
        return heapq.merge(*sources, key=lambda message: message.stamp)

    def of_frame(self, frame: Frame) -> Message:
        """Return a frame as a message on the topic of its interface."""
        stamp = nanoseconds(frame.time)
        is_fd, is_error, is_extended = (bool(frame.flags & bit) for bit in (FD, ERROR, EXTENDED))
        data = np.frombuffer(frame.data if is_fd else frame.data.ljust(8, b"\0"), np.uint8)
        kind = CAN_FD_FRAME if is_fd else CAN_FRAME
        remote = () if is_fd else (bool(frame.flags & REMOTE),)
        flags = (*remote, is_extended, is_error)
        content = self._make(kind, self._header(stamp, frame.channel), frame.can_id, *flags, frame.size, data)
        topic = "".join(letter if letter.isascii() and letter.isalnum() else "_" for letter in frame.channel)
        return self._message(f"/can_fd/{topic}" if is_fd else f"/can/{topic}", kind, stamp, content)

    def of_event(self, event: BusEvent) -> Message:
        """Return an event as a message of a log."""
        stamp, kind = nanoseconds(event.time), "rcl_interfaces/msg/Log"
        level = WARN if event.is_problem else INFO
        name = "bus" if event.node is None else f"node {event.node}"
        content = self._make(kind, self._time(stamp), level, name, event.what, "", "", 0)
        return self._message("/events", kind, stamp, content)

    def _joints(self, recording: Recording) -> Iterator[Message]:
        """Yield the positions of wheels, joints and link that were read in each sample [rad, m]."""
        names = recording.vehicle.channels
        positions = np.column_stack([channel_values(recording, name) for name in names])
        shown = np.where(recording.present, positions, np.nan)
        return self._joint_states("/joint_states", "position", recording.time, names, shown)

    def _commands(self, recording: Recording) -> Iterator[Message]:
        """Yield the wheel speeds that were commanded before each sample [rad/s]."""
        names = recording.vehicle.wheels
        commands = np.zeros((0, len(names))) if recording.commands is None else recording.commands
        return self._joint_states("/commands", "velocity", recording.time[: len(commands)], names, commands)

    def _joint_states(
        self, topic: str, field: str, time: Array, names: Sequence[str], values: Array
    ) -> Iterator[Message]:
        """Yield one field of the joints by row of `values` `(N, C)`, without those that are nan."""
        kind, nothing = "sensor_msgs/msg/JointState", np.zeros(0)
        for at, row, known in zip(time.tolist(), values, ~np.isnan(values), strict=True):
            if known.any():
                stamp = nanoseconds(at)
                there = [str(name) for name, is_there in zip(names, known.tolist(), strict=True) if is_there]
                fields = (row[known], nothing) if field == "position" else (nothing, row[known])
                content = self._make(kind, self._header(stamp, ""), there, *fields, nothing)
                yield self._message(topic, kind, stamp, content)

    def _path(self, path: Path) -> Iterator[Message]:
        """Yield the poses of a truck with their speeds."""
        kind = "nav_msgs/msg/Odometry"
        rates = speeds(path.time, path.pose).tolist()
        for time, pose, (speed, turning) in zip(path.time.tolist(), path.pose.tolist(), rates, strict=True):
            if math.isnan(pose[0]):
                continue
            stamp = nanoseconds(time)
            motion = self._make(
                "geometry_msgs/msg/Twist", self._vector(speed), self._vector(0.0, 0.0, turning)
            )
            twist = self._make("geometry_msgs/msg/TwistWithCovariance", motion, np.zeros(36))
            pose_known = self._covered(pose, np.zeros(36))
            content = self._make(kind, self._header(stamp, WORLD), _body(path), pose_known, twist)
            yield self._message(f"/{path.method}/{path.truck}", kind, stamp, content)

    def _transforms(self, paths: Sequence[Path]) -> Iterator[Message]:
        """Yield where the frames of all trucks are at each sample."""
        kind = "tf2_msgs/msg/TFMessage"
        poses = zip(*(path.pose.tolist() for path in paths), strict=True)
        for time, places in zip(paths[0].time.tolist(), poses, strict=True):
            stamp = nanoseconds(time)
            header, transforms = self._header(stamp, WORLD), []
            for path, (x, y, theta) in zip(paths, places, strict=True):
                if not math.isnan(x):
                    moved = self._make("geometry_msgs/msg/Transform", self._vector(x, y), self._turn(theta))
                    transforms.append(
                        self._make("geometry_msgs/msg/TransformStamped", header, _body(path), moved)
                    )
            yield self._message("/tf", kind, stamp, self._make(kind, transforms))

    def _measured(self, drive: Drive) -> Iterator[Message]:
        """Yield the absolute poses, and as points those whose heading was not measured."""
        poses = drive.recording.poses
        if poses is None:
            return
        rows = zip(poses.time.tolist(), poses.body.tolist(), poses.pose.tolist(), poses.sigma, strict=True)
        for time, body, pose, sigma in rows:
            if math.isnan(pose[0]) or math.isnan(pose[1]):
                continue
            stamp = nanoseconds(time)
            if math.isnan(pose[2]):
                topic, kind = f"/positions/{body}", "geometry_msgs/msg/PointStamped"
                content = self._make("geometry_msgs/msg/Point", pose[0], pose[1], 0.0)
            else:
                topic, kind = f"/poses/{body}", "geometry_msgs/msg/PoseWithCovarianceStamped"
                covariance = np.zeros(36)
                covariance[[_X, _Y, _YAW]] = np.nan_to_num(sigma**2)
                content = self._covered(pose, covariance)
            content = self._make(kind, self._header(stamp, WORLD), content)
            yield self._message(topic, kind, stamp, content)

    def _make(self, kind: str, *fields: Any) -> object:  # noqa: ANN401 - types are made at run time
        """Return a message or a part of one from its fields in their order."""
        content: object = self.typestore.types[kind](*fields)
        return content

    def _message(self, topic: str, kind: str, stamp: int, content: object) -> Message:
        return Message(topic, kind, stamp, bytes(self.typestore.serialize_cdr(content, kind)))

    def _header(self, stamp: int, frame: str) -> object:
        return self._make("std_msgs/msg/Header", self._time(stamp), frame)

    def _time(self, stamp: int) -> object:
        whole, rest = divmod(stamp, NANOSECOND)
        if whole > MAX_TIME:
            raise ExportError(self._target, f"a time of {whole} s; ROS 2 counts up to {MAX_TIME} s, in 2038")
        return self._make("builtin_interfaces/msg/Time", whole, rest)

    def _vector(self, x: float, y: float = 0.0, z: float = 0.0) -> object:
        return self._make("geometry_msgs/msg/Vector3", x, y, z)

    def _covered(self, pose: list[float], covariance: Array) -> object:
        """Return a pose x, y, theta with a covariance `(36,)`."""
        place = self._make("geometry_msgs/msg/Point", pose[0], pose[1], 0.0)
        whole = self._make("geometry_msgs/msg/Pose", place, self._turn(pose[2]))
        return self._make("geometry_msgs/msg/PoseWithCovariance", whole, covariance)

    def _turn(self, theta: float) -> object:
        """Return a heading as a quaternion."""
        half = 0.5 * theta
        return self._make("geometry_msgs/msg/Quaternion", 0.0, 0.0, math.sin(half), math.cos(half))


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
