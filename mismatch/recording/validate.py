"""Whether recordings can be diagnosed at all: one robot, one clock, enough of a drive."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omnimate.vehicle.errors import RecordingError
from omnimate.vehicle.odometry import truck_travel

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.vehicle.recording import Recording

SHORTEST = 15.0  # [s] of driving, all together: a lap's worth
WAY = 1.0  # [m] rolled, all together
_JUMP = 1.0  # [s] without a sample, after which the clock is said to have jumped
_HALF = 0.5  # share of samples in which a channel has to be there


def check(recordings: Sequence[Recording]) -> None:
    """Refuse recordings that are no recordings of one robot on one clock.

    Raises:
        RecordingError: what is wrong, in which recording, and what to do.
    """
    first = recordings[0]
    for one in recordings:
        if (
            one.vehicle.name != first.vehicle.name
            or one.vehicle.expected_channels != first.vehicle.expected_channels
        ):
            raise RecordingError(
                one.source,
                f"is of {one.vehicle.name!r} and {first.source} of {first.vehicle.name!r}; "
                "diagnose the recordings of one robot at a time",
            )
        if one.vehicle.trucks != first.vehicle.trucks or one.vehicle.linkage != first.vehicle.linkage:
            raise RecordingError(
                one.source,
                f"has another geometry in vehicle.toml than {first.source}; "
                "diagnose recordings that were made with the same vehicle.toml",
            )
        _check_clock(one)
        _check_channels(one)
        _check_poses(one)
        _check_laps(one)


def _check_clock(recording: Recording) -> None:
    steps = np.diff(recording.time)
    if len(steps) and float(steps.min()) <= 0.0:
        back = int(np.argmin(steps))
        raise RecordingError(
            recording.source,
            f"the clock goes back by {-steps[back]:.3f} s at {recording.time[back]:.3f} s; "
            "cut the log there and diagnose the parts as recordings of their own",
        )
    longest = max(_JUMP, 20.0 * float(np.median(steps))) if len(steps) else _JUMP
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
        if share < _HALF:
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
    if inside.mean() < _HALF:
        raise RecordingError(
            recording.source,
            f"{100.0 * (1.0 - inside.mean()):.0f} % of the poses lie outside the time of can.log "
            f"({recording.time[0]:.3f} to {recording.time[-1]:.3f} s; poses from {poses.time.min():.3f} to "
            f"{poses.time.max():.3f} s): they are on another clock; shift poses.csv to the clock of can.log",
        )


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
    """Return why recordings are too little to tell anything, and what to record; empty where they are not."""
    span = sum(float(one.time[-1] - one.time[0]) for one in recordings)
    if span < SHORTEST:
        return f"{span:.1f} s of data are too little; record a minute or more, with turns both ways."
    way = 0.0
    for one in recordings:
        for truck in one.vehicle.trucks:
            left, right, _ = truck_travel(one, truck)
            way += float(np.abs(np.diff(left)).sum() + np.abs(np.diff(right)).sum()) / 2.0
    if way < WAY:
        return f"the wheels rolled {way:.2f} m only; record a drive of several metres with turns both ways."
    single = recordings[0].vehicle.linkage is None
    if single and all(one.poses is None for one in recordings):
        return (
            "a single truck without absolute poses has nothing to be held against; "
            "measure its pose from outside (poses.csv), at the stops at least."
        )
    return ""
