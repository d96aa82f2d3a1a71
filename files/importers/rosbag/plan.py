"""The plan of a bag: topic and part of a message for each channel and for the poses of each truck."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Literal, get_args

from omnimate.files.importers.errors import MappingError
from omnimate.files.importers.robots import robot_of
from omnimate.files.importers.tables import Table, read_table
from omnimate.files.importers.units import UNITS
from omnimate.vehicle.parameters import CHANNELS, TRUCKS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.vehicle.parameters import Channel, TruckName, VehicleParameters

Stamps = Literal["header", "bag"]


@dataclass(frozen=True, slots=True)
class ChannelSource:
    """The place of a channel's values in a bag.

    Attributes:
        topic: Topic of the messages.
        part: Name of the joint in a JointState; otherwise the dotted name of the field, with an index last:
            `data`, `ticks.left`, `data.0`.
        unit: A unit of `omnimate.files.importers.units.UNITS`; empty for that of the type of message.
    """

    topic: str
    part: str = ""
    unit: str = ""


@dataclass(frozen=True, slots=True)
class PoseSource:
    """The place of a truck's absolute poses in a bag.

    Attributes:
        topic: Topic of the messages.
        frame: Child frame, which is needed for messages with several transforms.
        offset: Time that is added to the stamps [s].
    """

    topic: str
    frame: str = ""
    offset: float = 0.0


@dataclass(frozen=True, slots=True)
class Plan:
    """The places of all quantities in a bag.

    Attributes:
        channels: Place of each channel of the robot.
        poses: Place of the absolute poses of each truck; may be empty.
        stamps: "header" for the stamps of the messages' headers where there are any, "bag" for those of the
            bag.
    """

    channels: dict[Channel, ChannelSource] = field(default_factory=dict)
    poses: dict[TruckName, PoseSource] = field(default_factory=dict)
    stamps: Stamps = "header"


def plan_of(mapping: Table) -> Plan:
    """Return the plan of a mapping's tables `[channel.*]` and `[poses.*]`.

    Raises:
        MappingError: A key or a value is wrong.
    """
    channels: dict[Channel, ChannelSource] = {}
    for name, entry in mapping.tables("channel", CHANNELS):
        part = entry.text("joint", "") or entry.text("field", "")
        entry.text("field", "")  # an optional key, ignored beside a joint
        channels[_channel(name)] = ChannelSource(
            entry.text("topic"), part, entry.text("unit", "", among=("", *UNITS))
        )
        entry.done()
    poses: dict[TruckName, PoseSource] = {}
    for name, entry in mapping.tables("poses", TRUCKS):
        poses[_truck(name)] = PoseSource(
            entry.text("topic"), entry.text("frame", ""), entry.number("offset", 0.0)
        )
        entry.done()
    stamps = mapping.text("stamps", "header", among=get_args(Stamps))
    return Plan(channels, poses, "bag" if stamps == "bag" else "header")


def read_plan(path: Path | str, vehicle: VehicleParameters | None = None) -> tuple[Plan, VehicleParameters]:
    """Return the plan of a TOML file, and the robot: the one given, or that of the file.

    Raises:
        MappingError: The file cannot be read, or a key or a value is wrong.
        VehicleFileError: The robot's file is wrong.
    """
    table = read_table(path)
    plan, robot = plan_of(table), robot_of(table, Path(path).parent, vehicle)
    table.done()
    return plan, robot


def plan_of_options(channels: Sequence[str], poses: Sequence[str]) -> Plan:
    """Return the plan of options such as `a.left=/joint_states:left_wheel:rad` and `a=/mocap/pose:base`.

    Raises:
        MappingError: An option has another form.
    """
    given: dict[Channel, ChannelSource] = {}
    for option in channels:
        name, parts = _split(option, "CHANNEL=TOPIC[:JOINT or FIELD[:UNIT]]", 3)
        source = ChannelSource(*parts)
        if source.unit not in {"", *UNITS}:
            raise MappingError(option, f"unit {source.unit!r}; expected one of {', '.join(UNITS)}")
        given[_channel(name)] = source
    placed: dict[TruckName, PoseSource] = {}
    for option in poses:
        name, parts = _split(option, "TRUCK=TOPIC[:FRAME]", 2)
        placed[_truck(name)] = PoseSource(parts[0], parts[1] if len(parts) > 1 else "")
    return Plan(given, placed)


def _split(option: str, form: str, most: int) -> tuple[str, list[str]]:
    name, equals, rest = option.partition("=")
    parts = rest.split(":")
    if not equals or not parts[0] or len(parts) > most:
        raise MappingError(option, f"expected {form}")
    return name, parts


def _channel(name: str) -> Channel:
    for channel in CHANNELS:
        if channel == name:
            return channel
    raise MappingError(name, f"no channel; expected one of {', '.join(CHANNELS)}")


def _truck(name: str) -> TruckName:
    for truck in TRUCKS:
        if truck == name:
            return truck
    raise MappingError(name, f"no truck; expected one of {', '.join(TRUCKS)}")
