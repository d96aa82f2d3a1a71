"""A recording from a ROS bag and a plan that says which topic holds which quantity.

Times are the stamps of the headers. Where a topic has none, or a stamp is zero, they are the times at which
the bag received the messages: these are delayed by the network, and the recording's notes say so.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from omnimate.files.errors import SourceError
from omnimate.files.importers.clock import recording_of
from omnimate.files.importers.rosbag.reader import messages_of
from omnimate.files.importers.rosbag.values import JOINTS, channel_value, pose_value
from omnimate.files.importers.series import Series, check_times, merge_poses, poses_of
from omnimate.vehicle.recording import Lap, Run

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from omnimate.files.importers.rosbag.plan import Plan, Stamps
    from omnimate.files.importers.rosbag.reader import Message
    from omnimate.files.importers.rosbag.values import StampedValue
    from omnimate.vehicle.parameters import Channel, TruckName, VehicleParameters
    from omnimate.vehicle.recording import Poses, Recording
    from omnimate.vehicle.se2 import Array


class Imported(NamedTuple):
    """A recording, and notes for the user on how it was made."""

    recording: Recording
    notes: tuple[str, ...]


class _Taken:
    """The values of one channel or truck in a bag.

    `name` is file and topic, for messages; `bag` are the times at which the bag received the messages [ns].
    """

    def __init__(self, path: Path | str, topic: str) -> None:
        self.name, self.topic = f"{path}, topic {topic}", topic
        self.bag: list[int] = []
        self.values: list[StampedValue] = []
        self.kinds: set[str] = set()

    def add(self, message: Message, value: StampedValue | None) -> None:
        """Add the value in a message; None for none."""
        if value is not None:
            self.bag.append(message.time)
            self.values.append(value)
            self.kinds.add(message.kind)


def read_bag(
    path: Path | str,
    plan: Plan,
    vehicle: VehicleParameters,
    progress: Callable[[int, int], None] | None = None,
) -> Imported:
    """Return the recording that a bag holds.

    The bag is of ROS 1, ROS 2 or MCAP; `progress` is called with the messages read and their total.

    Raises:
        SourceError: The bag cannot be read, or does not hold the topics of the plan.
    """
    for channel in vehicle.channels:
        if channel not in plan.channels:
            raise SourceError(path, f"nothing says which topic channel {channel} is; --list shows the topics")
    for truck in plan.poses:
        if truck not in vehicle.trucks:
            raise SourceError(path, f"poses of truck {truck}, but {vehicle.name} has no such truck")
    channels = {channel: _Taken(path, source.topic) for channel, source in plan.channels.items()}
    poses = {truck: _Taken(path, place.topic) for truck, place in plan.poses.items()}
    topics = {taken.topic for taken in (*channels.values(), *poses.values())}
    for message in messages_of(path, sorted(topics), progress):
        for channel, source in plan.channels.items():
            if source.topic == message.topic:
                channels[channel].add(message, channel_value(message, source))
        for truck, place in plan.poses.items():
            if place.topic == message.topic:
                poses[truck].add(message, pose_value(message, place))
    notes: list[str] = []
    series = {channel: _series(plan, channel, channels[channel], notes) for channel in vehicle.channels}
    placed = merge_poses(_poses(plan, truck, poses[truck], notes) for truck in plan.poses)
    first = max(float(channel_series.time[0]) for channel_series in series.values())
    last = min(float(channel_series.time[-1]) for channel_series in series.values())
    run = Run("free", None, (Lap("none", first, last),)) if last > first else None
    return Imported(recording_of(vehicle, series, str(path), placed, run), tuple(dict.fromkeys(notes)))


def _series(plan: Plan, channel: Channel, taken: _Taken, notes: list[str]) -> Series:
    source = plan.channels[channel]
    name = f"{taken.name}{f', {source.part}' if source.part else ''}"
    if not taken.values:
        raise SourceError(name, "no message of that joint; --list shows the joints of every topic")
    natural = ("m" if channel == "link" else "rad") if JOINTS in taken.kinds else "counts"
    time, values = _columns(name, plan.stamps, taken, notes)
    return Series(time, values[:, 0], source.unit or natural, name)


def _poses(plan: Plan, truck: TruckName, taken: _Taken, notes: list[str]) -> Poses:
    source = plan.poses[truck]
    if not taken.values:
        raise SourceError(taken.name, f"no transform of frame {source.frame!r}; --list shows the frames")
    if "nav_msgs/Odometry" in taken.kinds:
        notes.append(
            f"{source.topic} is nav_msgs/Odometry: where the robot makes it of its own wheels, "
            "it is no absolute pose"
        )
    time, values = _columns(taken.name, plan.stamps, taken, notes)
    return poses_of(truck, time + source.offset, values[:, :3], values[:, 3:])


def _columns(name: str, clock: Stamps, taken: _Taken, notes: list[str]) -> tuple[Array, Array]:
    """Return times `(K,)` [s] and values `(K, ...)`; of messages with equal stamps the first is used."""
    topic, stamps = taken.topic, np.array([value.stamp for value in taken.values], np.int64)
    if clock == "bag" or not stamps.all():
        if clock != "bag":
            notes.append(f"{topic} has no stamps; its times are those at which the bag got the messages")
        stamps = np.array(taken.bag, np.int64)
    fresh = np.concatenate(([True], np.diff(stamps) != 0))
    if not fresh.all():
        notes.append(f"{topic}: {int((~fresh).sum())} message(s) with the stamp of the one before left out")
    time = np.asarray(stamps[fresh] * 1e-9, np.float64)
    check_times(time, lambda row: f"{name}, message {np.flatnonzero(fresh)[row] + 1}")
    return time, np.array([value.numbers for value in taken.values], np.float64)[fresh]
