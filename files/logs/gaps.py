"""Where a channel was not read, and why."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omnimate.vehicle.recording import Gap

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from omnimate.vehicle.parameters import Channel
    from omnimate.vehicle.recording import GapReason


def gaps_of(
    channel: Channel,
    time: NDArray[np.float64],
    present: NDArray[np.bool_],
    received: NDArray[np.bool_],
    restarts: NDArray[np.bool_],
) -> list[Gap]:
    """Return the gaps of one channel, in order of time.

    Args:
        channel: Channel of the encoder.
        time: Time of each sample [s], shape `(N,)`.
        present: Whether a reading was believed, shape `(N,)`.
        received: Whether a reading was received, shape `(N,)`.
        restarts: Whether the device had restarted before a sample, shape `(N,)`.
    """
    where = np.concatenate(([-1], np.flatnonzero(present), [len(time)]))
    restarted = np.concatenate((np.cumsum(restarts), [np.sum(restarts)]))
    gaps = []
    for place in np.flatnonzero((np.diff(where) > 1) | (np.diff(restarted[where]) > 0)).tolist():
        first, last = int(where[place]), int(where[place + 1])
        start, end = float(time[max(first, 0)]), float(time[min(last, len(time) - 1)])
        reason: GapReason = "jump" if received[first + 1 : last].any() else "missing"
        if first >= 0 and restarted[last] > restarted[first]:
            reason = "reboot"
        gaps.append(Gap(channel, start, end, reason))
    return gaps
