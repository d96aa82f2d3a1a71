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
    """How full the bus is."""

    rate: float  # frames per second
    least: float  # bits per second of classical frames without stuff bits
    most: float  # bits per second of classical frames with every possible stuff bit


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
    """The bus at one moment."""

    time: float  # when it was taken, as wall time [s], or the time in a log that is replayed
    since: float  # time since the watch began [s]
    frames: int  # number of frames so far
    left_out: int  # number of frames that are none, or of identifiers beyond those that are counted
    traffic: Traffic  # how full the bus is
    rows: tuple[LiveRow, ...]  # frames by identifier
    # last reported NMT state of each node, by interface and node id
    nodes: Mapping[tuple[str, int], NodeSeen]
    events: tuple[Event, ...]  # events in order of time
    # PDO parameters that SDO traffic showed, by node, index and sub-index
    seen: Mapping[tuple[int, int, int], int]
    robot: RobotView | None  # where the robot is; None without a vehicle or before the first sample
    lost: str | None  # why the bus cannot be read now; None where it can
    recording: Path | None  # folder or file that is being recorded; None where none is
    has_ended: bool  # whether it was a log, and its last frame was received
