"""A guess of the plan of a bag by names and types of its topics, to be confirmed by the user."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from omnimate.files.importers.rosbag.plan import ChannelSource, Plan, PoseSource
from omnimate.files.importers.rosbag.values import JOINTS, POSES
from omnimate.vehicle.parameters import TRUCKS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.files.importers.rosbag.reader import Topic
    from omnimate.vehicle.parameters import Channel, TruckName

_TICKS = tuple(f"std_msgs/{sign}Int{bits}" for sign in ("", "U") for bits in (16, 32, 64))
_WHEEL = re.compile(r"wheel|tick|encoder|enc|drive|motor")
_COMMANDED = re.compile(r"(^|_)(commands?|cmd|targets?|setpoints?)(_|$)")
_SIDES: dict[Channel, re.Pattern[str]] = {
    "a.left": re.compile(r"(^|_)(left|l)(_|$)"),
    "a.right": re.compile(r"(^|_)(right|r)(_|$)"),
}
_WHEELS = tuple(_SIDES)
_MEASURED = re.compile(r"truth|mocap|motion_?capture|vicon|optitrack|qualisys|gt(_|$)|total_?station|vrpn")


def guess_plan(topics: Sequence[Topic], channels: Sequence[Channel] = _WHEELS) -> Plan:
    """Return the plan that names and types suggest; ambiguous channels and poses are left out."""
    sources, poses = _sources(topics, channels), _poses(topics)
    return Plan(
        {channel: named[0] for channel, named in sources.items() if len(named) == 1},
        _exported_poses(topics, channels) or ({"a": PoseSource(poses[0])} if len(poses) == 1 else {}),
    )


def ambiguities(topics: Sequence[Topic], channels: Sequence[Channel], plan: Plan) -> list[str]:
    """Return a sentence for all that a plan leaves open because several names in the bag fit."""
    options = {
        f"--channel {channel}=": [f"{source.topic}:{source.part}".rstrip(":") for source in named]
        for channel, named in _sources(topics, channels).items()
        if channel not in plan.channels
    }
    if not plan.poses:
        options["--pose a="] = _poses(topics)
    return [
        f"ambiguous, give one: {' or '.join(option + name for name in names)}"
        for option, names in options.items()
        if len(names) > 1
    ]


def _sources(topics: Sequence[Topic], channels: Sequence[Channel]) -> dict[Channel, list[ChannelSource]]:
    """Return for each channel all that are named like it."""
    candidates = [
        ChannelSource(topic.name, part if topic.kind == JOINTS else "")
        for topic in topics
        if (topic.kind == JOINTS or topic.kind in _TICKS) and not _COMMANDED.search(_normalised(topic.name))
        for part in (topic.parts if topic.kind == JOINTS else ("",))
    ]
    single = len(channels) == len(_WHEELS)
    return {channel: _named_like(channel, candidates, single) for channel in channels}


def _named_like(channel: Channel, candidates: Sequence[ChannelSource], single: bool) -> list[ChannelSource]:
    names = {source: _normalised(source.part or source.topic) for source in candidates}
    named = [source for source in candidates if _normalised(channel) in names[source]]
    if not named and single:
        named = [source for source in candidates if _SIDES[channel].search(names[source])]
        named = [source for source in named if _WHEEL.search(names[source])] or named
    return named


def _normalised(name: str) -> str:
    """Return a name in lower case with underscores between its words."""
    spaced = re.sub(r"([a-z0-9])([A-Z])", r"\1_\2", name)
    return re.sub(r"[^a-z0-9]+", "_", spaced.lower())


def _exported_poses(topics: Sequence[Topic], channels: Sequence[Channel]) -> dict[TruckName, PoseSource]:
    """Return the poses of all trucks on the topics that `omnimate export` writes; empty where it did not."""
    places = {truck: f"/poses/{truck}" for truck in TRUCKS if f"{truck}.left" in channels}
    there = {topic.name for topic in topics if topic.kind in POSES and topic.count}
    return {truck: PoseSource(name) for truck, name in places.items() if name in there}


def _poses(topics: Sequence[Topic]) -> list[str]:
    """Return topics that may be poses of truck a, preferably one named like a measurement, never odometry."""
    able = [topic for topic in topics if topic.kind in POSES and topic.count and not topic.parts]
    measured = [topic.name for topic in able if _MEASURED.search(_normalised(topic.name))]
    other = [topic.name for topic in able if topic.kind != "nav_msgs/Odometry"]
    return measured if len(measured) == 1 else other


def plan_as_toml(plan: Plan) -> str:
    """Return a plan as the text of an equivalent mapping file."""
    lines = []
    for channel, source in plan.channels.items():
        lines += [f'[channel."{channel}"]', f'topic = "{source.topic}"']
        lines += [f'joint = "{source.part}"'] if source.part else []
        lines += [f'unit = "{source.unit}"'] if source.unit else []
    for truck, place in plan.poses.items():
        lines += [f"[poses.{truck}]", f'topic = "{place.topic}"']
    return "\n".join(lines)
