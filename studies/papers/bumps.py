"""One bump under one wheel: the paper's formulas, C (4)-(8), and the drive that they describe."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from omnimate.effects.crossing import chord_loss
from omnimate.ipec.corrector import correct
from omnimate.ipec.errors import NoLinkageError
from omnimate.vehicle.arcs import arc, integrate
from omnimate.vehicle.linkage import linkage_of
from omnimate.vehicle.parameters import CHANNELS, WHEELS, Channel, VehicleParameters
from omnimate.vehicle.recording import Recording
from omnimate.vehicle.se2 import Array
from studies.papers.robots import fine

LOST = chord_loss(0.075, 0.010)  # [m] C Table I
SPEED, PERIOD, LINK = 0.5, 0.040, 1.0  # [m/s], [s], [m] C 3.1
_BEFORE, _CROSSING = 0.5, 0.02  # [m] of travel before the bump, and over which its loss is spread


@dataclass(frozen=True, slots=True)
class BumpDrive:
    """A straight drive over one bump, and where the trucks truly are."""

    recording: Recording  # what the encoders count, at their resolution
    pose_a: Array  # true pose of truck a at each sample [m, m, rad], shape `(N, 3)`
    pose_b: Array  # true pose of truck b at each sample [m, m, rad], shape `(N, 3)`
    way: Array  # travel that the wheels have rolled [m], shape `(N,)`


def bump_drive(vehicle: VehicleParameters, lost: float, *, after: float = 2.0) -> BumpDrive:
    """Return a straight drive in line over one bump under truck a's right wheel, all else being perfect.

    The wheel loses some travel [m] on the bump, and goes on for the travel `after` it [m].
    NoLinkageError: the robot has a single truck.
    """
    if vehicle.linkage is None:
        raise NoLinkageError(vehicle.name)
    step = SPEED * vehicle.bus.sync_period
    way: Array = step * np.arange(math.ceil((_BEFORE + _CROSSING + after) / step) + 1, dtype=np.float64)
    travel = np.repeat(way[:, None], 4, axis=1)
    travel[:, WHEELS.index("a.right")] -= lost * np.clip((way - _BEFORE) / _CROSSING, 0.0, 1.0)
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


@dataclass(frozen=True, slots=True)
class BumpErrors:
    """What one bump does to plain odometry, and to the measurement of that error."""

    heading: float  # heading error after the bump [rad], C (4)
    lateral: float  # lateral error per metre driven after the bump [m/m], C (5)
    lateral_in_interval: float  # largest lateral error within one sampling interval [m], C (6)
    misread: float  # part of the heading error that this lateral error hides from the linkage [rad], C (7)
    measured: float  # heading error that the linkage shows [rad], C (8)


def bump_errors(lost: float, wheelbase: float, interval: float, link_length: float) -> BumpErrors:
    """Return the errors that one wheel's lost travel [m] makes, C (4)-(8).

    `wheelbase` is b [m], `interval` the travel within one sampling interval D_s [m], `link_length` L [m].
    """
    heading = math.asin(lost / wheelbase)
    inside = interval * math.sin(heading)
    misread = math.asin(inside / link_length)
    return BumpErrors(heading, lost / wheelbase, inside, misread, heading - misread)


_INTERVALS = 15  # that are shown after the bump


@dataclass(frozen=True, slots=True)
class Growth:
    """Errors, true minus estimated, at each sampling interval from the one in which the bump is met on."""

    plain: Array  # heading [rad] and lateral [m] error of odometry alone, shape `(N, 2)`
    ipec: Array  # heading [rad] and lateral [m] error of IPEC, C (9)-(16), shape `(N, 2)`
    seen: Array  # part of the heading's error that the linkage has shown so far [rad], shape `(N,)`
    printed: BumpErrors  # errors by the paper's formulas, C (4)-(8)


def bump_growth() -> Growth:
    """Return what one 10 mm bump under truck a's right wheel does, all else being perfect."""
    robot = fine()
    robot = replace(robot, bus=replace(robot.bus, sync_period=PERIOD))
    drive = bump_drive(robot, LOST)
    met = int(np.searchsorted(drive.way, _BEFORE - 1e-9))
    shown = slice(met, met + _INTERVALS + 1)
    start = drive.pose_a[0]
    plain = correct(drive.recording, start, method="plain")
    ipec = correct(drive.recording, start, method="clapper")

    def error(path: Array) -> Array:
        return np.asarray((drive.pose_a - path)[shown][:, [2, 1]])

    step = SPEED * PERIOD
    printed = bump_errors(LOST, robot.trucks["a"].wheelbase, step, LINK)
    seen = np.cumsum(ipec.corrections[:, 0])[shown]
    return Growth(error(plain.pose_a), error(ipec.pose_a), seen, printed)
