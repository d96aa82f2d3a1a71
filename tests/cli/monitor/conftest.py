"""Snapshots of a bus that was never there."""

from pathlib import Path

import pytest

from omnimate.cli.descriptions import descriptions
from omnimate.driver.robot.bus_watch import Snapshot, Traffic
from omnimate.driver.robot.events import Event
from omnimate.driver.robot.robot_watch import RobotView
from omnimate.files.logs.bus_events import NodeSeen
from omnimate.files.logs.frames import ERROR, EXTENDED, FD, REMOTE, Frame
from omnimate.files.logs.live_table import LiveRow

ROWS = (
    LiveRow(Frame(10.0, 0x080), 500, 66.7, 1e-5, 0.01, ()),
    LiveRow(Frame(10.0, 0x181, bytes.fromhex("10270000")), 500, 66.7, 1e-4, 0.01, (True, False, False, True)),
    LiveRow(Frame(7.0, 0x705, b"\x05"), 3, 0.0, 0.0, 3.0, (False,)),
    LiveRow(Frame(9.9, 0x18FF0001, b"", EXTENDED | REMOTE, 4), 1, 0.0, 0.0, 0.1, ()),
    LiveRow(Frame(9.9, 0x1F0, bytes(12), FD), 2, 5.0, 0.0, 0.1, (False,) * 12),
    LiveRow(Frame(9.9, 0x004, bytes(8), ERROR), 2, 5.0, 0.0, 0.1, (False,) * 8),
)


@pytest.fixture
def snapshot():
    """A robot that drives, with an EMCY and a lost node."""
    robot = RobotView(
        100,
        ("b.left",),
        {"joint_a": 0.1, "joint_b": -0.2, "link": 1.0},
        {"a.left": 0.2, "a.right": -0.21, "b.left": float("nan"), "b.right": 0.2},
        {"a": (1.25, -0.5, 0.1), "b": (0.25, -0.5, 0.0)},
    )
    events = (
        Event(95.0, 99.0, 12, None, "error frame of the adapter", is_problem=True),
        Event(90.0, 90.0, 1, 5, "is operational, was pre-operational"),
    )
    nodes = {("can0", 5): NodeSeen(5, 7.0), ("can0", 6): NodeSeen(0x7F, 9.0)}
    return Snapshot(
        100.0,
        125.0,
        1006,
        2,
        Traffic(1000.4, 110_000.0, 130_000.0),
        ROWS,
        nodes,
        events,
        {},
        robot,
        None,
        Path("recording-1"),
        has_ended=False,
    )


@pytest.fixture
def known():
    """Nothing is known of the frames but CANopen's own."""
    return descriptions(None, (), ())
