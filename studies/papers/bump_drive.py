"""A straight drive of two trucks over one bump, everything else being perfect, as their encoders count it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.ipec.errors import NoLinkageError
from omnimate.vehicle.arcs import arc, integrate
from omnimate.vehicle.linkage import linkage_of
from omnimate.vehicle.parameters import CHANNELS, WHEELS
from omnimate.vehicle.recording import Recording

if TYPE_CHECKING:
    from omnimate.vehicle.parameters import Channel, VehicleParameters
    from omnimate.vehicle.se2 import Array


@dataclass(frozen=True, slots=True)
class BumpDrive:
    """A straight drive over one bump, and where the trucks truly are.

    Attributes:
        recording: What the encoders count, at their resolution.
        pose_a: True pose of truck a at each sample [m, m, rad], shape `(N, 3)`.
        pose_b: True pose of truck b at each sample [m, m, rad], shape `(N, 3)`.
        way: Travel that the wheels have rolled [m], shape `(N,)`.
    """

    recording: Recording
    pose_a: Array
    pose_b: Array
    way: Array


def bump_drive(
    vehicle: VehicleParameters,
    lost: float,
    *,
    wheel: Channel = "a.right",
    speed: float = 0.5,
    before: float = 0.5,
    crossing: float = 0.02,
    after: float = 2.0,
) -> BumpDrive:
    """Return a straight drive in line over one bump, everything else being perfect.

    Args:
        vehicle: Robot with two trucks; its encoders' resolution and its SYNC period are used.
        lost: Travel that the wheel loses on the bump [m].
        wheel: Channel of the wheel that meets the bump.
        speed: Speed of the wheels [m/s].
        before: Travel before the bump [m].
        crossing: Travel over which the loss is spread [m].
        after: Travel after the bump [m].

    Raises:
        NoLinkageError: The robot has a single truck.
    """
    if vehicle.linkage is None:
        raise NoLinkageError(vehicle.name)
    step = speed * vehicle.bus.sync_period
    way: Array = step * np.arange(math.ceil((before + crossing + after) / step) + 1, dtype=np.float64)
    travel = np.repeat(way[:, None], 4, axis=1)
    travel[:, WHEELS.index(wheel)] -= lost * np.clip((way - before) / crossing, 0.0, 1.0)
    steps = np.diff(travel, axis=0)
    pose_a = integrate(arc(steps[:, 0], steps[:, 1], vehicle.trucks["a"].wheelbase))
    behind = (-vehicle.linkage.length, 0.0, 0.0)
    pose_b = integrate(arc(steps[:, 2], steps[:, 3], vehicle.trucks["b"].wheelbase), behind)
    joint_a, joint_b, length = linkage_of(pose_a, pose_b)
    read = dict(zip(CHANNELS, [way] * 4 + [joint_a, joint_b, length - vehicle.linkage.length], strict=True))
    counts = np.stack([_counts(vehicle, channel, read[channel]) for channel in vehicle.channels], axis=1)
    time = vehicle.bus.sync_period * np.arange(len(way), dtype=np.float64)
    recording = Recording(vehicle, time, counts, np.ones(counts.shape, np.bool_), source="a bump")
    return BumpDrive(recording, pose_a, pose_b, way)


def _counts(
    vehicle: VehicleParameters, channel: Channel, value: Array
) -> np.ndarray[tuple[int, ...], np.dtype[np.int64]]:
    """Return what an encoder counts at values [m] or [rad], to the nearest count."""
    encoder = vehicle.encoder(channel)
    if channel in WHEELS:
        return np.round(value / vehicle.metres_per_count(channel)).astype(np.int64)
    return encoder.zero + np.round(value / encoder.scale).astype(np.int64)
