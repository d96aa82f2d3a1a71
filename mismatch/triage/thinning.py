"""Recordings with as few samples as a first question needs."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from omnimate.mismatch.recording.signals import WINDOW

if TYPE_CHECKING:
    from omnimate.vehicle.recording import Recording

SAMPLES = 3  # in a window, which still show an acceleration and a reversal


def thinned(recording: Recording) -> Recording:
    """Return a recording with about three samples in each window, of each few the one that lacks least.

    Counters are absolute, so nothing of the way is lost.
    """
    time = recording.time
    if len(time) < 2:
        return recording
    few = int(WINDOW / SAMPLES / float(np.median(np.diff(time))) * (1.0 + 1e-6))
    if few < 2:
        return recording
    whole = len(time) // few * few
    read = recording.present[:whole].sum(axis=1).reshape(-1, few)
    at = np.arange(0, whole, few) + np.argmax(read, axis=1)
    return replace(
        recording, time=time[at], counts=recording.counts[at], present=recording.present[at], commands=None
    )
