"""Tracking sample by sample: rows written, a status line shown, disturbances and frozen channels reported."""

from __future__ import annotations

import contextlib
import math
from typing import TYPE_CHECKING

from omnimate.cli.console import note, warn
from omnimate.cli.following import follow
from omnimate.cli.track.words import disturbance_in_words, frozen_in_words, row_in_words

if TYPE_CHECKING:
    from collections.abc import Iterable

    from omnimate.cli.track.rows import RowWriter
    from omnimate.ipec.tracker import Tracker
    from omnimate.vehicle.sample import Sample

CHECK = 5.0  # [s] between two checks for frozen channels


def follow_robot(
    samples: Iterable[Sample], tracker: Tracker, writer: RowWriter, *, seconds: float | None, every: float
) -> None:
    """Take samples until the time is up, the source ends or Ctrl-C; write rows, say what happens.

    Args:
        samples: The samples of a bus, as they come.
        tracker: The tracker, which takes each sample.
        writer: Receives a row every `every` seconds.
        seconds: After how long to end [s]; None for never.
        every: Time between two rows [s].
    """
    first: float | None = None
    written, checked = -math.inf, 0.0
    reported: set[str] = set()
    followed = follow(samples, seconds, lambda last, passed: row_in_words(tracker.look(), last.time - passed))
    with contextlib.closing(followed):
        for sample in followed:
            tracker.step(sample)
            if first is None:
                first = checked = sample.time
            if sample.time - written >= every - 1e-9:
                written = sample.time
                writer.write(tracker.row())
            _report_disturbances(tracker, first)
            if sample.time - checked >= CHECK:
                checked = sample.time
                _report_frozen(tracker, reported)


def _report_disturbances(tracker: Tracker, first: float) -> None:
    """Print the disturbances that have ended."""
    for disturbance in tracker.take_disturbances():
        sentence = disturbance_in_words(disturbance, first, tracker.vehicle)
        note(sentence)


def _report_frozen(tracker: Tracker, reported: set[str]) -> None:
    """Print each frozen channel when it is seen for the first time."""
    for frozen in tracker.frozen():
        if frozen.channel not in reported:
            reported.add(frozen.channel)
            warn(frozen_in_words(frozen, tracker.vehicle))
