"""Errors of correctors and estimators: robots or recordings that they cannot process."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.vehicle.errors import InputError

if TYPE_CHECKING:
    from omnimate.vehicle.parameters import Channel


class IpecError(InputError):
    """The root of this room's errors."""


class NoLinkageError(IpecError):
    """A recording or robot, `source`, without a second truck, which every correction needs."""

    def __init__(self, source: str) -> None:
        super().__init__(
            source,
            "a robot with a single truck has no linkage; expected two trucks: follow one by "
            "`omnimate track` or omnimate.ipec.tracker.track_one_truck, or name truck b, [linkage] and their "
            "encoders in vehicle.toml",
        )


class FixError(IpecError):
    """Fixes of a recording, `source`, from which the filter cannot start."""

    def __init__(self, source: str) -> None:
        super().__init__(
            source,
            "no fix of truck a has x, y and heading; expected one in poses.csv, from which the filter "
            "starts; without --fixes it starts from 0",
        )


class LinkageChannelError(IpecError):
    """A linkage channel of a recording or robot, `source`, that was never read, or was frozen."""

    def __init__(self, source: str, channel: Channel, node: int, problem: str) -> None:
        super().__init__(source, f"{channel} (node {node}) {problem}")
        self.channel = channel
