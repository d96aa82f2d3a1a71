"""What else may be at work than a floor: the hypotheses under which the filter runs, side by side.

An encoder of the linkage may read what is neither its angle nor a constant bias: its joint has play or lies
off its centre, its slider sticks, its reading is late. The error stays alike while the linkage moves as much
as a way of its own length moves it, or as long as a side of the robot's path lasts.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

READINGS = ("joint_a", "joint_b", "link", "wheels of a", "wheels of b")


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """What a reading may do.

    Attributes:
        reading: Number in `READINGS` of what wanders; -1 for nothing.
        wander: Standard deviation of what it wanders from its bias [rad] or [m].
        alike: Way over which that error stays alike [lengths of the link].
    """

    reading: int = -1
    wander: float = 0.0
    alike: float = 1.0


# Largest error of each: a loose joint, 0.9 degrees; 3 mm, C 6 states of its linear encoder. The smallest is a
# 27th of it, a tenth of what a rotary encoder of 1024 steps resolves; what is smaller is lost in the floor.
LARGEST = (math.radians(0.9), math.radians(0.9), 0.003, math.radians(0.9), math.radians(0.9))
HYPOTHESES = (
    Hypothesis(),
    *(
        Hypothesis(reading, LARGEST[reading] / 3.0**scale, alike)
        for reading, scale, alike in itertools.product(range(5), range(4), (1.0, 4.0))
    ),
)
"""What is compared: all is well, or one reading wanders. Ways of 1 and 4 link lengths are a motion of the
linkage, and a side of the papers' squares and laps."""


def chances_before(wrong: float) -> list[float]:
    """Return the logarithm of each hypothesis' probability before a drive.

    Args:
        wrong: Probability that a given reading wanders.
    """
    others = [hypothesis.reading for hypothesis in HYPOTHESES[1:]]
    right = math.log(1.0 - wrong)
    alone = math.log(wrong) + (len(READINGS) - 1) * right
    return [len(READINGS) * right, *(alone - math.log(others.count(reading)) for reading in others)]
