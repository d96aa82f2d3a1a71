"""Recordings with a fault, and as a driver gives them."""

import math
from dataclasses import replace

from omnimate.vehicle.sample import Sample


def frozen(recording, channel, first=0):
    """Return the recording with a channel that stops counting at a sample."""
    counts = recording.counts.copy()
    column = recording.vehicle.channels.index(channel)
    counts[first:, column] = counts[first, column]
    return replace(recording, counts=counts)


def samples(recording):
    """Yield the samples of a recording as a driver would."""
    nothing = (math.nan,) * recording.counts.shape[1]
    for index, time in enumerate(recording.time.tolist()):
        counts, present = recording.counts[index].tolist(), recording.present[index].tolist()
        yield Sample(index, time, tuple(counts), tuple(present), nothing, nothing)
