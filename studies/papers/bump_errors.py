"""The growth-rate concept, C 3: a bump's heading error is there at once, its lateral error grows slowly."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class BumpErrors:
    """What one bump does to plain odometry, and to the measurement of that error.

    Attributes:
        heading: Heading error after the bump [rad], C (4).
        lateral: Lateral error per metre driven after the bump [m/m], C (5).
        lateral_in_interval: Largest lateral error within one sampling interval [m], C (6).
        misread: Part of the heading error that this lateral error hides from the linkage [rad], C (7).
        measured: Heading error that the linkage shows [rad], C (8).
    """

    heading: float
    lateral: float
    lateral_in_interval: float
    misread: float
    measured: float


def bump_errors(lost: float, wheelbase: float, interval: float, link_length: float) -> BumpErrors:
    """Return the errors that one wheel's lost travel makes, C (4)-(8).

    Args:
        lost: Travel that the wheel loses on the bump [m], C (1).
        wheelbase: Wheelbase b of the truck [m].
        interval: Travel within one sampling interval, D_s [m].
        link_length: Length L of the link [m].
    """
    heading = math.asin(lost / wheelbase)
    inside = interval * math.sin(heading)
    misread = math.asin(inside / link_length)
    return BumpErrors(heading, lost / wheelbase, inside, misread, heading - misread)
