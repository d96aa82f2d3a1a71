"""The controller: wheel speeds from a commanded motion; the second truck of a pair follows the linkage."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from studies.mismatch.engines.true_motion import Nominal

    Array = NDArray[np.float64]

ALIGN = 1.5  # [1/s], gain with which truck b turns into the link
HOLD = 0.6  # [1/s], gain with which truck b keeps the link's length
INTO = 2.0  # gain with which truck a, driving backwards, turns into the link, over the link's length


def wheel_speeds(nominal: Nominal, speed: float, rate: float, linkage: Array) -> Array:
    """Return the speeds of all wheels [rad/s], shape `(2 T,)`.

    Args:
        nominal: The robot as the controller knows it.
        speed: Speed of truck a [m/s].
        rate: Its turn rate [rad/s].
        linkage: joint_a [rad], joint_b [rad] and the link's length [m], shape `(3,)`; not used of one truck.
    """
    motion = [(speed, rate)]
    if len(nominal.tracks) == 2:
        joint_a, joint_b, length = linkage
        motion = [(speed, rate + INTO / nominal.link * min(speed, 0.0) * joint_a)]
        motion += [(speed * math.cos(joint_a) + HOLD * (length - nominal.link), -ALIGN * joint_b)]
    ways = [
        forward + side * 0.5 * track * turn
        for (forward, turn), track in zip(motion, nominal.tracks, strict=True)
        for side in (-1.0, 1.0)
    ]
    return np.array(ways) / nominal.radii
