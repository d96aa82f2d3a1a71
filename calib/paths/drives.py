"""Drives for least squares: checked wheel readings and absolute poses without a lost counter."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from omnimate.calib.errors import CalibrationError, FixError
from omnimate.calib.recordings import check_one_robot, check_one_truck, check_wheels
from omnimate.vehicle.odometry import check_pose_units, truck_travel, wheels_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from omnimate.vehicle.parameters import TruckName
    from omnimate.vehicle.recording import Poses, Recording
    from omnimate.vehicle.se2 import Array


@dataclass(frozen=True, slots=True)
class Drive:
    """Wheel readings and absolute poses without a lost counter in between.

    Raises:
        FixError: There are fewer than two poses, or they go back in time.
        CalibrationError: A reading or a pose is not a number.
    """

    time: Array  # time of the readings [s], `(N,)`
    readings: Array  # continuous readings of the two sensors that the kinematic model uses, `(N, 2)`
    fix_time: Array  # time of the absolute poses [s], `(M,)`
    pose: Array  # absolute poses x, y [m], theta [rad], `(M, 3)`; nan where unknown
    sigma: Array  # standard deviations of the absolute poses, `(M, 3)`; nan where not stated
    source: str  # file or folder that the drive comes from, for messages

    def __post_init__(self) -> None:
        if len(self.fix_time) < 2:
            raise FixError(
                self.source,
                f"{len(self.fix_time)} absolute pose(s); a calibration needs two or more on one drive",
            )
        known = np.isfinite(self.pose)
        if not (known.any(axis=1).all() and np.isfinite(self.readings).all()):
            raise CalibrationError(self.source, "readings or poses that are not numbers")
        if np.any(np.diff(self.fix_time) < 0.0):
            raise FixError(self.source, "absolute poses go back in time; sort poses.csv by t")


def drives_of(recordings: Sequence[Recording], truck: TruckName = "a") -> tuple[Drive, ...]:
    """Return the drives of a truck in recordings of one robot, cut where a wheel's counter was lost.

    Raises:
        CalibrationError: There is no recording, the robots differ, the truck is missing, or a wheel never
            moves.
        FixError: There are too few poses, or they are on another clock.
    """
    check_one_robot(recordings)
    check_one_truck(recordings, truck)
    return tuple(drive for recording in recordings for drive in _drives(recording, truck))


def thin_fixes(drive: Drive, spacing: float) -> Drive:
    """Return a drive with absolute poses at least `spacing` [s] apart, including the last one.

    The errors of a dense reference are correlated in time: markers sway, the heading differs from that of the
    wheels from place to place, clocks drift. On the OptiOdom squares, such errors of the heading fade within
    1 to 2 s. Closer poses would be treated as independent, and their common error as roughness of the floor.
    """
    kept = [0]
    for number in range(1, len(drive.fix_time)):
        if drive.fix_time[number] - drive.fix_time[kept[-1]] >= spacing * (1.0 - 1e-6):
            kept.append(number)
    last = len(drive.fix_time) - 1
    if kept[-1] != last:
        kept = [*kept[:-1], last] if len(kept) > 1 else [*kept, last]
    return replace(drive, fix_time=drive.fix_time[kept], pose=drive.pose[kept], sigma=drive.sigma[kept])


def _drives(recording: Recording, truck: TruckName) -> list[Drive]:
    left, right, present = truck_travel(recording, truck)
    if not (np.ptp(left) or np.ptp(right)):
        raise CalibrationError(recording.source, f"neither wheel of truck {truck} moves; drive first")
    check_wheels(recording, truck)
    fixes = _fixes(recording, truck)
    angles = np.stack([recording.wheel_angle(wheel) for wheel in wheels_of(truck)], axis=-1)[present]
    time = recording.time[present]
    _check_gaps(recording, truck, fixes, time, angles)
    cuts = sorted(
        gap.end
        for gap in recording.gaps
        if gap.channel in wheels_of(truck) and gap.reason in {"reboot", "jump"}
    )
    pieces = []
    for start, end in zip([-np.inf, *cuts], [*cuts, np.inf], strict=True):
        inside = (fixes.time >= start) & (fixes.time < end)
        within = (time >= start) & (time < end)
        if inside.sum() >= 2 and within.sum() >= 2:
            moving = _moving(angles[within])
            pieces.append(
                Drive(
                    time[within][moving],
                    angles[within][moving],
                    fixes.time[inside],
                    fixes.pose[inside],
                    fixes.sigma[inside],
                    f"{recording.source}, truck {truck}",
                )
            )
    if not pieces:
        raise FixError(recording.source, f"no two absolute poses of truck {truck} without a reboot between")
    return pieces


def _check_gaps(recording: Recording, truck: TruckName, fixes: Poses, time: Array, angles: Array) -> None:
    """Raise an error where most poses lie in one gap of the samples `(N,)`, in which the wheels moved."""
    after = np.searchsorted(time, fixes.time).clip(1, len(time) - 1)
    gap = int(np.bincount(after).argmax())
    count = int(np.sum(after == gap))
    is_long = time[gap] - time[gap - 1] > _margin(recording)
    if is_long and 2 * count > len(after) and np.any(angles[gap] != angles[gap - 1]):
        raise FixError(
            recording.source,
            f"{count} of {len(after)} poses of truck {truck} lie where can.log has no samples, "
            f"{time[gap - 1]:.3f} to {time[gap]:.3f} s: its clock jumps, or frames are lost; cut the log "
            "there and calibrate from the parts as recordings of their own",
        )


def _margin(recording: Recording) -> float:
    """Return by how much time [s] a pose may miss the samples."""
    return 10.0 * recording.vehicle.bus.sync_period


def _moving(angles: Array) -> NDArray[np.bool_]:
    """Return which readings `(N,)` differ from the one before or after; the others add no information."""
    changed = np.any(np.diff(angles, axis=0) != 0.0, axis=1)
    moving = np.concatenate((changed, [True])) | np.concatenate(([True], changed))
    moving[0] = True
    return moving


def _fixes(recording: Recording, truck: TruckName) -> Poses:
    """Return the truck's absolute poses within the recording's time that have a known component."""
    if recording.poses is None or not np.any(recording.poses.body == truck):
        raise FixError(
            recording.source,
            f"poses.csv has no pose of truck {truck}; least squares needs absolute poses, dense or at stops",
        )
    check_pose_units(recording, truck)
    poses = recording.poses.of(truck)
    known = np.isfinite(poses.pose).any(axis=1) & np.isfinite(poses.time)
    first, last = float(recording.time[0]), float(recording.time[-1])
    margin = _margin(recording)
    inside = known & (poses.time >= first - margin) & (poses.time <= last + margin)
    if known.any() and not inside.any():
        raise FixError(
            recording.source,
            f"the poses of truck {truck} lie at {poses.time[known].min():.3f} to "
            f"{poses.time[known].max():.3f} s, the samples at {first:.3f} to {last:.3f} s; expected one "
            "clock: put poses.csv on that of can.log",
        )
    if inside.sum() < 2:
        raise FixError(
            recording.source, f"{inside.sum()} known pose(s) of truck {truck} in its time; two are needed"
        )
    return poses.select(inside)
