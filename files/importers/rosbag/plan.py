"""The plan of a bag: topic and part of a message for each channel and for the poses of each truck."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal, get_args

from omnimate.files.errors import MappingError
from omnimate.files.importers.robots import robot_of
from omnimate.files.importers.tables import Name, read_table
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

    A child frame is needed for messages with several transforms; the offset is added to the stamps [s].
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


def read_plan(path: Path | str, vehicle: VehicleParameters | None = None) -> tuple[Plan, VehicleParameters]:
    """Return the plan of a TOML file, and the robot: the one given, or that of the file.

    Raises:
        MappingError: The file cannot be read, or a key or a value is wrong.
        VehicleFileError: The robot's file is wrong.
    """
    table, plan = read_table(path), Plan()
    for channel, entry in table.tables("channel", CHANNELS):
        other = entry.text("field", "")
        part, unit = entry.text("joint", "") or other, entry.text("unit", "", among=("", *UNITS))
        plan.channels[channel] = ChannelSource(entry.text("topic"), part, unit)
        entry.done()
    for truck, entry in table.tables("poses", TRUCKS):
        offset = entry.number("offset", 0.0)
        plan.poses[truck] = PoseSource(entry.text("topic"), entry.text("frame", ""), offset)
        entry.done()
    stamps = table.text("stamps", "header", among=get_args(Stamps))
    robot = robot_of(table, Path(path).parent, vehicle)
    table.done()
    return replace(plan, stamps="bag" if stamps == "bag" else "header"), robot


def plan_of_options(channels: Sequence[str], poses: Sequence[str]) -> Plan:
    """Return the plan of options such as `a.left=/joint_states:left_wheel:rad` and `a=/mocap/pose:base`.

    Raises:
        MappingError: An option has another form.
    """
    plan = Plan()
    for option in channels:
        channel, parts = _split(option, "CHANNEL=TOPIC[:JOINT or FIELD[:UNIT]]", 3, "channel", CHANNELS)
        source = plan.channels[channel] = ChannelSource(*parts)
        if source.unit not in {"", *UNITS}:
            raise MappingError(option, f"unit {source.unit!r}; expected one of {', '.join(UNITS)}")
    for option in poses:
        truck, parts = _split(option, "TRUCK=TOPIC[:FRAME]", 2, "truck", TRUCKS)
        plan.poses[truck] = PoseSource(parts[0], parts[1] if len(parts) > 1 else "")
    return plan


def _split(option: str, form: str, most: int, what: str, names: Sequence[Name]) -> tuple[Name, list[str]]:
    """Return what an option is for, one of `names`, and its parts, `most` at the most."""
    name, equals, rest = option.partition("=")
    parts = rest.split(":")
    if not equals or not parts[0] or len(parts) > most:
        raise MappingError(option, f"expected {form}")
    for known in names:
        if known == name:
            return known, parts
    raise MappingError(name, f"no {what}; expected one of {', '.join(names)}")
