"""The result of configuring all nodes, and the vehicle with what they report: how each counter wraps."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from omnimate.driver.canopen.node_setup import NodeConfiguration
    from omnimate.driver.robot.bus_load import BusLoad
    from omnimate.vehicle.parameters import Encoder, VehicleParameters


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
