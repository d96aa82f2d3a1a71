"""Whether recordings can be diagnosed: one robot, one clock, a drive that is long enough."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omnimate.vehicle.errors import RecordingError
from omnimate.vehicle.odometry import check_pose_units, truck_travel
from omnimate.vehicle.recording import check_distinct

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.vehicle.recording import Recording

MIN_TIME = 15.0  # [s] of all recordings together: about a lap
MIN_TRAVEL = 1.0  # [m] rolled in all recordings together
MAX_GAP = 1.0  # [s] without a sample; a longer gap is a jump of the clock if the wheels moved meanwhile
MIN_PRESENT = 0.5  # fraction of samples in which a channel, and of poses that within the samples' time


def check(recordings: Sequence[Recording]) -> None:
    """Check that recordings are of one robot and on one clock, and that each is there once.

    Raises:
        RecordingError: There are none, or they are not; it states what is wrong, in which recording, and what
            to do.
    """
    if not recordings:
        raise RecordingError("diagnose", "no recordings were given; expected one or more")
    first = recordings[0]
    for recording in recordings:
        if (
            recording.vehicle.name != first.vehicle.name
            or recording.vehicle.expected_channels != first.vehicle.expected_channels
        ):
            raise RecordingError(
                recording.source,
                f"is of {recording.vehicle.name!r} and {first.source} of {first.vehicle.name!r}; "
                "diagnose the recordings of one robot at a time",
            )
        if (
            recording.vehicle.trucks != first.vehicle.trucks
            or recording.vehicle.linkage != first.vehicle.linkage
        ):
            raise RecordingError(
                recording.source,
                f"has another geometry in vehicle.toml than {first.source}; "
                "diagnose recordings that were made with the same vehicle.toml",
            )
        _check_clock(recording)
        _check_channels(recording)
        _check_poses(recording)
        _check_laps(recording)
    check_distinct(recordings)


def _check_clock(recording: Recording) -> None:
    steps = np.diff(recording.time)
    if len(steps) and float(steps.min()) <= 0.0:
        back = int(np.argmin(steps))
        if steps[back] == 0.0:
            raise RecordingError(
                recording.source,
                f"two samples have the time {recording.time[back]:.3f} s; expected one SYNC at a time: "
                "remove frames that are twice in the log",
            )
        raise RecordingError(
            recording.source,
            f"the clock goes back by {-steps[back]:.3f} s at {recording.time[back]:.3f} s; "
            "cut the log there and diagnose the parts as recordings of their own",
        )
    longest = max(MAX_GAP, 20.0 * float(np.median(steps))) if len(steps) else MAX_GAP
    for at in np.flatnonzero(steps > longest).tolist():
        moved = np.abs(np.diff(recording.counts[at : at + 2], axis=0)).max()
        if steps[at] > 10.0 or moved > 0:
            raise RecordingError(
                recording.source,
                f"the clock jumps by {steps[at]:.3f} s at {recording.time[at]:.3f} s; "
                "cut the log there and diagnose the parts as recordings of their own",
            )


def _check_channels(recording: Recording) -> None:
    for channel in recording.vehicle.expected_channels:
        if channel not in recording.vehicle.channels:
            raise RecordingError(
                recording.source, f"vehicle.toml has no encoder for {channel}; expected one for each channel"
            )
        share = float(recording.is_present(channel).mean())
        if share < MIN_PRESENT:
            encoder = recording.vehicle.encoder(channel)
            raise RecordingError(
                recording.source,
                f"{channel} is there in {100.0 * share:.0f} % of the samples only (node {encoder.node}, "
                f"COB-ID {encoder.cob_id:03X}h); check its wiring and cob_id and start_bit in vehicle.toml",
            )


def _check_poses(recording: Recording) -> None:
    poses = recording.poses
    if poses is None or len(poses.time) == 0:
        return
    inside = (poses.time >= recording.time[0]) & (poses.time <= recording.time[-1])
    if inside.mean() < MIN_PRESENT:
        raise RecordingError(
            recording.source,
            f"{100.0 * (1.0 - inside.mean()):.0f} % of the poses lie outside the time of can.log "
            f"({recording.time[0]:.3f} to {recording.time[-1]:.3f} s; poses from {poses.time.min():.3f} to "
            f"{poses.time.max():.3f} s): they are on another clock; shift poses.csv to the clock of can.log",
        )
    for truck in recording.vehicle.trucks:
        check_pose_units(recording, truck)


def _check_laps(recording: Recording) -> None:
    if recording.run is None:
        return
    for number, lap in enumerate(recording.run.laps):
        if lap.end <= recording.time[0] or lap.start >= recording.time[-1]:
            raise RecordingError(
                recording.source,
                f"lap {number} of run.toml ({lap.start:.3f} to {lap.end:.3f} s) lies outside the time of "
                f"can.log ({recording.time[0]:.3f} to {recording.time[-1]:.3f} s); correct it",
            )


def too_little(recordings: Sequence[Recording]) -> str:
    """Return why recordings are insufficient, and what to record; empty where they suffice."""
    span = sum(float(recording.time[-1] - recording.time[0]) for recording in recordings)
    if span < MIN_TIME:
        return f"{span:.1f} s of data are too little; record a minute or more, with turns both ways."
    rolled = 0.0
    for recording in recordings:
        for truck in recording.vehicle.trucks:
            left, right, _ = truck_travel(recording, truck)
            rolled += float(np.abs(np.diff(left)).sum() + np.abs(np.diff(right)).sum()) / 2.0
    if rolled < MIN_TRAVEL:
        return (
            f"the wheels rolled {rolled:.2f} m only; record a drive of several metres with turns both ways."
        )
    is_single = recordings[0].vehicle.linkage is None
    poses = [recording.poses for recording in recordings if recording.poses is not None]
    if is_single and not any(np.isfinite(of_recording.pose).any() for of_recording in poses):
        return (
            "a single truck without absolute poses has nothing to be held against; "
            "measure its pose from outside (poses.csv), at the stops at least."
        )
    return ""
