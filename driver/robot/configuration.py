"""The result of configuring the nodes: what was read, what was changed, and how each counter wraps."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from omnimate.driver.robot.bus_load import BusLoad
    from omnimate.vehicle.parameters import Channel, Encoder, VehicleParameters


@dataclass(frozen=True, slots=True)
class NodeConfiguration:
    """What was read at one node, what was changed, and what an operator should check.

    Attributes:
        node: CANopen node id.
        names: Channels that the node measures, or wheels that it drives.
        read: What was read before anything was changed, one line each.
        changed: What the driver changed, one line each; empty where all was right.
        remarks: What an operator should check, one line each.
        ranges: Range by which each channel is unwrapped [counts].
        lengths: Bytes of each PDO of the node, by COB-ID.
        timed: COB-IDs of those that are sent by the device's own timer.
        heartbeat: Heartbeat period [s]; None where the node has none.
        encoder_objects: Values that a CiA 406 encoder reports about itself, by index, such as the offset
            6509h and the serial number 650Bh.
        woken: What it took to have the node answer, in words; None where it answered.
    """

    node: int
    names: tuple[str, ...]
    read: tuple[str, ...] = ()
    changed: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()
    ranges: dict[Channel, int] = field(default_factory=dict)
    lengths: dict[int, int] = field(default_factory=dict)
    timed: frozenset[int] = frozenset()
    heartbeat: float | None = None
    encoder_objects: dict[int, int] = field(default_factory=dict)
    woken: str | None = None

    def lines(self) -> tuple[tuple[str, str], ...]:
        """Return each line with its kind: found, changed or remark."""
        changed = (*self.changed, self.woken) if self.woken else self.changed
        kinds = (("found", self.read), ("changed", changed), ("remark", self.remarks))
        return tuple((kind, line) for kind, lines in kinds for line in lines)


@dataclass(frozen=True, slots=True)
class ConfigurationReport:
    """The configuration of all nodes.

    Attributes:
        nodes: Configuration of each node, in order of the node ids.
        load: Forecast of the bus load.
        vehicle: The vehicle with the ranges by which the counters are unwrapped.
    """

    nodes: tuple[NodeConfiguration, ...]
    load: BusLoad
    vehicle: VehicleParameters

    def rows(self) -> list[tuple[str, str, str, str]]:
        """Return node, channels, kind and text of each line to print."""
        rows = [("bus", "", "load", self.load.in_words())]
        for node in self.nodes:
            rows += [(str(node.node), ", ".join(node.names), kind, line) for kind, line in node.lines()]
        return rows


def with_remarks(node: NodeConfiguration, remarks: Sequence[str]) -> NodeConfiguration:
    """Return a node's configuration with more that an operator should check."""
    return replace(node, remarks=(*node.remarks, *remarks))


def with_ranges(vehicle: VehicleParameters, nodes: Sequence[NodeConfiguration]) -> VehicleParameters:
    """Return the vehicle with the chosen range of each encoder whose range in `vehicle.toml` differs."""
    ranges = {channel: chosen for node in nodes for channel, chosen in node.ranges.items()}
    encoders = tuple(
        encoder
        if ranges.get(encoder.channel, encoder.wrap_range) == encoder.wrap_range
        else replace(encoder, range=ranges[encoder.channel])
        for encoder in vehicle.encoders
    )
    return vehicle if encoders == vehicle.encoders else replace(vehicle, encoders=encoders)


def with_target_bits(vehicle: VehicleParameters, bits: Mapping[int, int]) -> VehicleParameters:
    """Return the vehicle with the first bit of 60FFh in the RPDO of each drive, given by node id."""
    drives = tuple(replace(drive, start_bit=bits[drive.node]) for drive in vehicle.drives)
    return vehicle if drives == vehicle.drives else replace(vehicle, drives=drives)


def choose_range(encoder: Encoder, reported: int | None) -> tuple[int, str]:
    """Return the range by which a channel is unwrapped [counts], and the reason in words.

    6002h means N for some vendors, N - 1 for others, and 0 means 2**32 for one.

    Args:
        encoder: Encoder as `vehicle.toml` describes it.
        reported: Value of 6002h in the device; None where the device has no such object.
    """
    stated, full = encoder.wrap_range, 2**encoder.bits
    name = encoder.channel
    if reported is None:
        return stated, f"{name}: wraps at {stated}; the device has no 6002h"
    if reported == stated:
        return stated, f"{name}: wraps at {stated}; 6002h says so and means N"
    if reported == stated - 1:
        return stated, f"{name}: wraps at {stated}; 6002h says {reported} and means N - 1"
    if reported == 0 and full == 2**32 and encoder.range is None:
        return full, f"{name}: wraps at 2**32; 6002h says 0"
    guess = reported + reported % 2
    if encoder.range is not None or not 1 < guess <= full:
        return (
            stated,
            f"{name}: 6002h says {reported}, but vehicle.toml {stated}, which is used: check it",
        )
    means = "N - 1" if reported % 2 else "N"
    return (
        guess,
        f"{name}: wraps at {guess}; 6002h says {reported}, taken for {means}; vehicle.toml says nothing",
    )
