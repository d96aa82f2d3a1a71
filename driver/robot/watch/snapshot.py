"""A bus at one moment: frames by identifier, node states, events, and the robot's pose."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from omnimate.driver.robot.events import Event
    from omnimate.files.logs.bus_events import NodeSeen
    from omnimate.files.logs.live_table import LiveRow
    from omnimate.vehicle.arcs import PoseTuple
    from omnimate.vehicle.parameters import Channel, TruckName


class Traffic(NamedTuple):
    """How full the bus is.

    Attributes:
        rate: Frames per second.
        least: Bits per second of classical frames without stuff bits.
        most: Bits per second of classical frames with every possible stuff bit.
    """

    rate: float
    least: float
    most: float


@dataclass(frozen=True, slots=True)
class RobotView:
    """Where the robot is by the last sample.

    Attributes:
        samples: Number of samples.
        missing: Channels that the last sample lacks.
        linkage: Angle of each joint [rad] and length of the link [m].
        speeds: Speed of each wheel over the last second [m/s], by the time stamps of its frames.
        poses: Pose of each truck by odometry, from zero at the first sample [m, m, rad].
    """

    samples: int
    missing: tuple[Channel, ...]
    linkage: Mapping[Channel, float]
    speeds: Mapping[Channel, float]
    poses: Mapping[TruckName, PoseTuple]


@dataclass(frozen=True, slots=True)
class Snapshot:
    """The bus at one moment.

    Attributes:
        time: When it was taken, as wall time [s], or the time in a log that is replayed.
        since: Time since the watch began [s].
        frames: Number of frames so far.
        left_out: Number of frames that are none, or of identifiers beyond those that are counted.
        traffic: How full the bus is.
        rows: Frames by identifier.
        nodes: Last reported NMT state of each node, by interface and node id.
        events: Events in order of time.
        seen: PDO parameters that SDO traffic showed, by node, index and sub-index.
        robot: Where the robot is; None without a vehicle or before the first sample.
        lost: Why the bus cannot be read now; None where it can.
        recording: Folder or file that is being recorded; None where none is.
        has_ended: Whether it was a log, and its last frame was received.
    """

    time: float
    since: float
    frames: int
    left_out: int
    traffic: Traffic
    rows: tuple[LiveRow, ...]
    nodes: Mapping[tuple[str, int], NodeSeen]
    events: tuple[Event, ...]
    seen: Mapping[tuple[int, int, int], int]
    robot: RobotView | None
    lost: str | None
    recording: Path | None
    has_ended: bool
