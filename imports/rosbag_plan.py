"""What of a bag is what: topic and part of a message for each channel and for the poses of each truck."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Literal, get_args

from imports.errors import MappingError
from imports.robots import robot_of
from imports.tables import Table, read_table
from imports.units import UNITS
from vehicle.parameters import CHANNELS, TRUCKS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from vehicle.parameters import Channel, TruckName, VehicleParameters

Stamps = Literal["header", "bag"]


@dataclass(frozen=True, slots=True)
class ChannelSource:
    """Where a channel's values are.

    Attributes:
        topic: of the messages.
        part: the joint's name in a JointState; else the field, dotted, an index last: `data`,
            `ticks.left`, `data.0`.
        unit: one of `imports.units.UNITS`; empty: what the type of message suggests.
    """

    topic: str
    part: str = ""
    unit: str = ""


@dataclass(frozen=True, slots=True)
class PoseSource:
    """Where a truck's absolute poses are.

    Attributes:
        topic: of the messages.
        frame: child frame, which a message of several transforms needs.
        offset: added to their times [s].
    """

    topic: str
    frame: str = ""
    offset: float = 0.0


@dataclass(frozen=True, slots=True)
class Plan:
    """What of a bag is what.

    Attributes:
        channels: one for each channel of the robot.
        poses: by truck; may be empty.
        stamps: of the messages' headers where they have any, or of the bag throughout.
    """

    channels: dict[Channel, ChannelSource] = field(default_factory=dict)
    poses: dict[TruckName, PoseSource] = field(default_factory=dict)
    stamps: Stamps = "header"


def plan_of(mapping: Table) -> Plan:
    """Return the plan of a mapping's tables `[channel.*]` and `[poses.*]`.

    Raises:
        MappingError: a key or a value is wrong.
    """
    channels: dict[Channel, ChannelSource] = {}
    for name, one in mapping.tables("channel", CHANNELS):
        part = one.text("joint", "") or one.text("field", "")
        one.text("field", "")  # it may be there beside a joint, and is not looked at
        channels[_channel(name)] = ChannelSource(
            one.text("topic"), part, one.text("unit", "", among=("", *UNITS))
        )
        one.done()
    poses: dict[TruckName, PoseSource] = {}
    for name, one in mapping.tables("poses", TRUCKS):
        poses[_truck(name)] = PoseSource(one.text("topic"), one.text("frame", ""), one.number("offset", 0.0))
        one.done()
    stamps = mapping.text("stamps", "header", among=get_args(Stamps))
    return Plan(channels, poses, "bag" if stamps == "bag" else "header")


def read_plan(path: Path | str, vehicle: VehicleParameters | None = None) -> tuple[Plan, VehicleParameters]:
    """Return the plan of a TOML file, and the robot: the one given, or that of the file.

    Raises:
        MappingError: it cannot be read, or says what no mapping may.
        VehicleFileError: the robot's file is wrong.
    """
    table = read_table(path)
    plan, robot = plan_of(table), robot_of(table, Path(path).parent, vehicle)
    table.done()
    return plan, robot


def plan_of_options(channels: Sequence[str], poses: Sequence[str]) -> Plan:
    """Return the plan of options such as `a.left=/joint_states:left_wheel:rad` and `a=/mocap/pose:base`.

    Raises:
        MappingError: an option is none.
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
