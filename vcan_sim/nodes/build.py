"""Building of the devices in a vehicle's parameters, each with the EDS file and settings of its kind."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from omnimate.vcan_sim.errors import SimulationError
from omnimate.vcan_sim.nodes.drive import DriveDevice
from omnimate.vcan_sim.nodes.encoder import EncoderDevice, Sensor
from omnimate.vcan_sim.nodes.objects import Objects, load_dictionary

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from omnimate.vcan_sim.nodes.device import Device
    from omnimate.vcan_sim.nodes.encoder import Latch
    from omnimate.vcan_sim.nodes.objects import Key, Value
    from omnimate.vehicle.parameters import Drive, Encoder, VehicleParameters

WHEEL_EDS = "encoder_cia406.eds"
JOINT_EDS = "encoder_single_turn_cia406.eds"
LINK_EDS = "encoder_linear_cia406.eds"
DRIVE_EDS = "drive_cia402.eds"

# Ratios of a drive's ramps to the vehicle's own limit of acceleration [1], so that the drives do not limit a
# vehicle that keeps its limits; assumptions.
_RAMP_RESERVE = 2.0
_QUICK_STOP_RESERVE = 4.0
_SERIAL = 0x0026_0000  # serial number without the node id, which is added


def build_devices(
    vehicle: VehicleParameters, latch: Latch, send: Callable[[int, bytes], None]
) -> tuple[Device, ...]:
    """Return one device per node id, in the order of the ids.

    Raises SimulationError where the encoders and drives of one node cannot be on one device.
    """
    return tuple(_device(vehicle, latch, send, node) for node in vehicle.nodes)


def _device(
    vehicle: VehicleParameters, latch: Latch, send: Callable[[int, bytes], None], node: int
) -> Device:
    encoders = [encoder for encoder in vehicle.encoders if encoder.node == node]
    encoders.sort(key=lambda encoder: (encoder.cob_id, encoder.start_bit))  # the order of 6020h:n
    drives = [drive for drive in vehicle.drives if drive.node == node]
    for encoder in encoders:
        if encoder.bits > 32:
            raise SimulationError(f"node {node}: {encoder.channel} has {encoder.bits} bits; 6004h has 32")
    sensors = [Sensor(latch, vehicle.channels.index(encoder.channel), encoder) for encoder in encoders]
    if drives or any(encoder.profile == "cia402" for encoder in encoders):
        device = _drive(vehicle, node, drives, encoders, sensors, send)
    else:
        device = _encoder(node, encoders, sensors, send)
    for encoder, sensor in zip(encoders, sensors, strict=True):
        if encoder.position_object is not None:
            device.objects.readers[encoder.position_object] = sensor.position
    return device


def _objects(
    eds: str, position: Key, node: int, encoders: list[Encoder], settings: Mapping[Key, Value]
) -> Objects:
    """Return the objects of an EDS file, and those of vehicle.toml as copies of its `position`."""
    variables = load_dictionary(eds)
    keys = (encoder.position_object for encoder in encoders)
    added = {key: variables[position] for key in keys if key is not None}
    return Objects({**variables, **added}, node, settings)


def _encoder(
    node: int, encoders: list[Encoder], sensors: list[Sensor], send: Callable[[int, bytes], None]
) -> Device:
    first = encoders[0]
    kinds = {"link": LINK_EDS, "joint_a": JOINT_EDS, "joint_b": JOINT_EDS}
    settings = _identity(node, encoders)
    settings[0x6002, 0] = first.wrap_range & 0xFFFF_FFFF
    settings[0x650B, 0] = settings[0x1018, 4]
    if first.counts_per_metre is not None:
        step = round(1e9 / first.counts_per_metre)  # [nm]
        settings |= {(0x6005, 1): step, (0x6501, 0): step}
    elif first.counts_per_turn is not None:
        resolution = round(first.counts_per_turn)
        turns = min(max(first.wrap_range // resolution, 1), 0xFFFF)
        settings |= {(0x6001, 0): resolution, (0x6501, 0): resolution, (0x6502, 0): turns}
    objects = _objects(kinds.get(first.channel, WHEEL_EDS), (0x6004, 0), node, encoders, settings)
    if (0x6030, len(sensors)) not in objects:
        raise SimulationError(f"node {node}: {len(sensors)} channels are more than its encoder has")
    return EncoderDevice(objects, send, sensors)


def _drive(
    vehicle: VehicleParameters,
    node: int,
    drives: list[Drive],
    encoders: list[Encoder],
    sensors: list[Sensor],
    send: Callable[[int, bytes], None],
) -> Device:
    if len(drives) > 1 or len(encoders) > 1 or any(encoder.profile != "cia402" for encoder in encoders):
        raise SimulationError(f"node {node}: a CiA 402 drive has one wheel and at most one encoder, cia402")
    settings = _identity(node, encoders)
    scale = 0.0
    if drives:
        settings |= _motion_settings(vehicle, drives[0])
        scale = drives[0].sign * 2.0 * math.pi / drives[0].counts_per_turn
    objects = _objects(DRIVE_EDS, (0x6064, 0), node, encoders, settings)
    return DriveDevice(objects, send, scale, sensors[0] if sensors else None)


def _motion_settings(vehicle: VehicleParameters, drive: Drive) -> dict[Key, Value]:
    """Return resolution [increments] and ramps [increments/s^2] of a drive."""
    per_metre = drive.counts_per_turn / (math.pi * vehicle.wheel_diameter(drive.wheel))
    ramp = max(1, round(_RAMP_RESERVE * vehicle.limits.acceleration * per_metre))
    quick_stop = max(1, round(_QUICK_STOP_RESERVE * vehicle.limits.acceleration * per_metre))
    return {
        (0x608F, 1): round(drive.counts_per_turn),
        (0x6083, 0): ramp,
        (0x6084, 0): ramp,
        (0x6085, 0): quick_stop,
    }


def _identity(node: int, encoders: list[Encoder]) -> dict[Key, Value]:
    """Return 1018h: the values expected by vehicle.toml, and a serial number that is unique to the node."""
    settings: dict[Key, Value] = {(0x1018, 4): _SERIAL + node}
    for encoder in encoders:
        wanted = {1: encoder.vendor, 2: encoder.product, 4: encoder.serial}
        settings |= {(0x1018, sub): value for sub, value in wanted.items() if value is not None}
    return settings
