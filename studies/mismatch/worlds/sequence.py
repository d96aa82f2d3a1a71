"""Recordings of a robot on one clock, one after the other, and recordings cut in two."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.vehicle.recording import Recording

START, PAUSE = 1_593_000_000.0, 60.0  # [s] the clock of the first run, and from one run to the next


def in_sequence(recordings: Sequence[Recording]) -> list[Recording]:
    """Return recordings one after the other on one clock, as a robot records that stays switched on."""
    moved, start = [], START
    for recording in recordings:
        by = start - float(recording.time[0])
        moved.append(_shifted(recording, by))
        start = float(moved[-1].time[-1]) + PAUSE
    return moved


def _shifted(recording: Recording, by: float) -> Recording:
    poses, driven = recording.poses, recording.run
    if driven is not None:
        laps = (replace(lap, start=lap.start + by, end=lap.end + by) for lap in driven.laps)
        driven = replace(driven, laps=tuple(laps))
    gaps = (replace(gap, start=gap.start + by, end=gap.end + by) for gap in recording.gaps)
    return replace(
        recording,
        time=recording.time + by,
        poses=None if poses is None else replace(poses, time=poses.time + by),
        run=driven,
        gaps=tuple(gaps),
    )


def halves(recordings: Sequence[Recording]) -> tuple[list[Recording], list[Recording]]:
    """Return every other recording, and the rest; a recording that stands alone is cut in the middle.

    Every other one, because the first runs of a set may be cw and the last ones ccw.
    """
    if len(recordings) > 1:
        return list(recordings[::2]), list(recordings[1::2])
    (whole,) = recordings
    middle = len(whole) // 2
    return [_part(whole, slice(None, middle))], [_part(whole, slice(middle, None))]


def _part(recording: Recording, rows: slice) -> Recording:
    """Return some samples of a recording, with the poses and laps that lie in them."""
    time, poses, driven = recording.time[rows], recording.poses, recording.run
    start, end = float(time[0]), float(time[-1])
    if poses is not None:
        inside = (poses.time >= start) & (poses.time <= end)
        poses = replace(
            poses,
            time=poses.time[inside],
            body=poses.body[inside],
            pose=poses.pose[inside],
            sigma=poses.sigma[inside],
        )
    if driven is not None:
        laps = (
            replace(lap, start=max(lap.start, start), end=min(lap.end, end))
            for lap in driven.laps
            if lap.start < end and lap.end > start
        )
        driven = replace(driven, laps=tuple(laps))
    return replace(
        recording,
        time=time,
        counts=recording.counts[rows],
        present=recording.present[rows],
        poses=poses,
        run=driven,
        gaps=tuple(gap for gap in recording.gaps if gap.start >= start and gap.end <= end),
        commands=None if recording.commands is None else recording.commands[rows],
    )
