"""The part of a recording of which the whole diagnosis is made.

A linkage tells of both trucks at every sample, and a diagnosis takes time and memory in proportion to them:
five minutes take 20 to 90 s of processor time and 2.7 GB, while what triage sees there, such as a joint of
the floor, takes some seconds. So a robot with a linkage is diagnosed in the minute around what triage sees
first. A single truck is known where it docks alone, which needs the whole drive, and takes a second or two.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from omnimate.vehicle.recording import Poses

if TYPE_CHECKING:
    from omnimate.mismatch.diagnosis import Where
    from omnimate.vehicle.recording import Recording

PART = 60.0  # [s]


def part_of(recording: Recording, where: Where) -> Recording:
    """Return the part to diagnose: around what is seen first, or the middle where it is seen all along."""
    first, last = float(recording.time[0]), float(recording.time[-1])
    if recording.vehicle.linkage is None or last - first <= PART:
        return recording
    seen = min(where.intervals, default=(first, last))
    start = min(max(0.5 * (seen[0] + seen[1]) - 0.5 * PART, first), last - PART)
    return between(recording, start, start + PART)


def between(recording: Recording, start: float, end: float) -> Recording:
    """Return what a recording has from a time to another [s]: samples, poses, gaps and whole laps."""
    rows, poses, run = recording.between(start, end), recording.poses, recording.run
    if poses is not None:
        inside = (poses.time >= start) & (poses.time <= end)
        poses = Poses(poses.time[inside], poses.body[inside], poses.pose[inside], poses.sigma[inside])
    if run is not None:
        run = replace(run, laps=tuple(lap for lap in run.laps if start <= lap.start and lap.end <= end))
    return replace(
        recording,
        time=recording.time[rows],
        counts=recording.counts[rows],
        present=recording.present[rows],
        commands=None if recording.commands is None else recording.commands[rows],
        poses=poses if poses is not None and len(poses.time) else None,
        run=run,
        gaps=tuple(gap for gap in recording.gaps if start <= gap.start and gap.end <= end),
    )
