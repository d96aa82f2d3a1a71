"""Checks of recordings before a calibration: poses exist, all are of one robot, no channel is frozen."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from omnimate.calib.advice import Advice
from omnimate.calib.errors import CalibrationError
from omnimate.vehicle.odometry import truck_travel, wheels_of
from omnimate.vehicle.recording import check_distinct

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.vehicle.parameters import Channel, TruckName
    from omnimate.vehicle.recording import Recording

# What moves before a channel without a count is frozen (assumptions).
_OTHER_WHEEL_TRAVEL = 0.5  # [m] of the other wheel, for a wheel
_TRUCK_TURN = math.radians(20.0)  # [rad] of its truck, for a joint
_LINK_TRAVEL, _LINK_TRAVEL_IN_TURNS = 5.0, 2.0  # [m] of truck a, for the link; of a drive with turns


def has_fixes(recording: Recording, truck: TruckName) -> bool:
    """Return whether a recording holds absolute poses of a truck."""
    return recording.poses is not None and bool((recording.poses.body == truck).any())


def check_one_robot(recordings: Sequence[Recording]) -> None:
    """Check that recordings are of robots with the same name and trucks, and that each is there once.

    Raises:
        CalibrationError: There is no recording, or one is of another robot than the first.
        RecordingError: Two recordings hold the same drive.
    """
    if not recordings:
        raise CalibrationError("calibration", "no recording given")
    first, *others = recordings
    for other in others:
        if other.vehicle.expected_channels != first.vehicle.expected_channels:
            raise CalibrationError(
                other.source,
                f"its robot has {len(other.vehicle.trucks)} truck(s), that of {first.source} has "
                f"{len(first.vehicle.trucks)}; give recordings of one robot at a time",
            )
        if other.vehicle.name != first.vehicle.name:
            raise CalibrationError(
                other.source,
                f"it is of the robot {other.vehicle.name!r}, but {first.source} of {first.vehicle.name!r}; "
                "give recordings of one robot at a time (its name stands in vehicle.toml)",
            )
    check_distinct(recordings)


def check_one_truck(recordings: Sequence[Recording], truck: TruckName) -> None:
    """Check that recordings of one robot state the same parameters of a truck.

    Raises:
        CalibrationError: The robot has no such truck, or a recording has other parameters than the first one.
    """
    first, *others = recordings
    if truck not in first.vehicle.trucks:
        raise CalibrationError(first.source, f"the robot {first.vehicle.name} has no truck {truck}")
    for other in others:
        if other.vehicle.trucks[truck] != first.vehicle.trucks[truck]:
            raise CalibrationError(
                other.source,
                f"truck {truck} differs from that of {first.source}; expected one robot with one "
                "vehicle.toml: leave out those from before a calibration (`omnimate umbmark` takes one for "
                "all as --vehicle)",
            )


def check_frozen(recording: Recording) -> None:
    """Raise an error if a wheel or a channel of the linkage is frozen throughout a recording.

    Raises:
        CalibrationError: A channel is frozen. A frozen wheel is reported before channels of the linkage that
            may only seem frozen because of it.
    """
    for truck in recording.vehicle.trucks:
        check_wheels(recording, truck)
    for advice in frozen_linkage(recording):
        raise CalibrationError(recording.source, str(advice).removeprefix(f"{recording.source}: "))


def check_wheels(recording: Recording, truck: TruckName) -> None:
    """Check that no wheel shows one count throughout while the other of its truck rolls.

    Raises:
        CalibrationError: A wheel is frozen.
    """
    travels = [float(np.abs(np.diff(wheel)).sum()) for wheel in truck_travel(recording, truck)[:2]]
    for wheel, travel, other in zip(wheels_of(truck), travels, reversed(travels), strict=True):
        if travel == 0.0 and other > _OTHER_WHEEL_TRAVEL:
            raise CalibrationError(
                recording.source,
                f"wheel {wheel} is frozen: not one count while the other one rolls {other:.1f} m: check its "
                "encoder, and node, cob_id and start_bit in vehicle.toml, and record again",
            )


def frozen_linkage(recording: Recording) -> tuple[Advice, ...]:
    """Return an error for each channel of the linkage that shows one count from beginning to end."""
    advice = []
    trucks: tuple[tuple[Channel, TruckName], ...] = (("joint_a", "a"), ("joint_b", "b"), ("link", "a"))
    for channel, truck in trucks:
        if channel not in recording.vehicle.channels or np.ptp(recording.channel_counts(channel)) != 0:
            continue
        left, right, _ = truck_travel(recording, truck)
        turns = float(np.ptp(right - left)) / recording.vehicle.trucks[truck].wheelbase > _TRUCK_TURN
        travel = float(np.abs(np.diff(0.5 * (left + right))).sum())
        is_frozen = turns
        if channel == "link":
            is_frozen = travel > (_LINK_TRAVEL_IN_TURNS if turns else _LINK_TRAVEL)
        if is_frozen:
            what = f"{recording.source}: {channel} is frozen: {travel:.0f} m of driving, and not one count"
            do = "check its encoder, its cable and its cob_id, and record again; IPEC and --linkage need it"
            advice.append(Advice("error", what, do))
    return tuple(advice)
