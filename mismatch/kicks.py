"""Castors swing round in their own time, and no two kicks are alike: an effect tells their mean.

When a kick comes, and how far one is off from the mean, is noise about a reversal, and no mismatch.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omnimate.vcan_sim.effects.block import truck_number

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from omnimate.mismatch.signals import Signals
    from omnimate.vcan_sim.effects.castor_kick import CastorKick
    from omnimate.vehicle.se2 import Array

_BEFORE, _AFTER = 0.1, 0.3  # [s] about a reversal, in which castors swing round
_SCATTER = 0.1  # of the mean kick, by which single ones are off
_ARM = 0.01  # [m] on which a truck rolls while it is turned by a part of the kick


def loosen(
    signals: Signals, ends: NDArray[np.int64], kick: CastorKick, stated: Array, rounding: Array
) -> None:
    """Let a truck's heading be anyhow while its castors swing; a kick is told before and after it.

    The other truck is where the linkage says, a metre away: it is as loose as seen from a kick too early.

    Args:
        signals: of the recording.
        ends: (M + 1,) samples at which windows begin and end.
        kick: that acts at each reversal.
        stated: (M + 1, R) variance of what is measured, to which it is added.
        rounding: (M, n, n) process covariance, likewise.
    """
    time, first, number = signals.time[ends], signals.reading.shape[1], truck_number(kick.component)
    size = abs(kick.yaw)
    kicked = kick.act(signals.block)[0].twist - signals.block.twist
    for moment in signals.block.time[kicked[:, number, 2] != 0.0]:
        swinging = (time > moment - _BEFORE) & (time < moment + _AFTER)
        rows = [*range(first, stated.shape[1]), *([number] if first else [])]
        stated[np.ix_(swinging, rows)] += size**2
        window = min(int(np.searchsorted(time, moment)), len(rounding)) - 1
        spread = size * np.array([_ARM, _ARM, _SCATTER])
        own = slice(3 * number, 3 * number + 3)
        rounding[window, own, own] += np.diag(spread**2)
