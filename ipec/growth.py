"""The growth-rate concept, C 3: a bump's heading error is there at once, its lateral error grows slowly."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ipec.errors import NoLinkageError
from vehicle.linkage import linkage_of
from vehicle.odometry import arc, integrate
from vehicle.parameters import CHANNELS, WHEELS
from vehicle.recording import Recording

if TYPE_CHECKING:
    from vehicle.parameters import Channel, VehicleParameters
    from vehicle.se2 import Array


@dataclass(frozen=True, slots=True)
class BumpErrors:
    """What one bump does to plain odometry, and to the measurement of that error.

    Attributes:
        heading: error after the bump [rad], C (4).
        lateral: error per metre driven after it [m/m], C (5).
        lateral_in_interval: error within one sampling interval at most [m], C (6).
        misread: part of the heading error that this lateral error hides from the linkage [rad], C (7).
        measured: heading error that the linkage shows [rad], C (8).
    """

    heading: float
    lateral: float
    lateral_in_interval: float
    misread: float
    measured: float


def bump_errors(lost: float, wheelbase: float, interval: float, link_length: float) -> BumpErrors:
    """Return the errors that one wheel's lost travel makes.

    Args:
        lost: travel of the wheel [m], C (1).
        wheelbase: b [m].
        interval: travel within one sampling interval, D_s [m].
        link_length: L [m].
    """
    heading = math.asin(lost / wheelbase)
    inside = interval * math.sin(heading)
    misread = math.asin(inside / link_length)
    return BumpErrors(heading, lost / wheelbase, inside, misread, heading - misread)


@dataclass(frozen=True, slots=True)
class BumpDrive:
    """A straight drive over one bump, and where the trucks truly are.

    Attributes:
        recording: what the encoders count, at their resolution.
        pose_a: (N, 3) true.
        pose_b: (N, 3) true.
        way: (N,) that the wheels have rolled [m].
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
        vehicle: robot with two trucks; its encoders' resolution and its SYNC period hold.
        lost: travel that the wheel loses [m].
        wheel: that meets the bump.
        speed: of the wheels [m/s].
        before: way before the bump [m].
        crossing: way over which the loss is spread [m].
        after: way after it [m].

    Raises:
        NoLinkageError: the robot has a single truck.
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
