"""Geometry of a wheel that crosses an obstacle: rolled distance and lost travel along the crossing.

A stiff wheel that climbs over something turns further than it travels: while it is on the obstacle,
its centre swings about a point from -q to q. It rolls 2 r q, travels 2 r sin q and loses the
difference. Over a sharp edge the centre swings about the edge, at the distance r = R of the wheel's
radius; over a round cable about the cable's middle, at r = R + h / 2. CLAPPER's printed approximation
of the edge loses 2 (sqrt(2 R h) - sqrt(2 R h - h^2)), C (1)-(3).

With a wheelbase of 340 mm a cable of 10 mm turns a truck by 0.57 degrees, where 0.6 was measured (C 6.1).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np

if TYPE_CHECKING:
    from omnimate.vehicle.se2 import Array

Shape = Literal["chord", "edge", "cable"]
SHAPES: tuple[Shape, ...] = get_args(Shape)

_NEWTON_STEPS = 20


@dataclass(frozen=True, slots=True)
class Crossing:
    """One crossing of an obstacle by a stiff wheel."""

    reach: float  # distance of the wheel's centre from its centre of rotation, r [m]
    half_angle: float  # half of the angle through which the centre swings, q [rad]
    travelled: float  # travel that the centre travels over the ground, 2 r sin q [m]

    @property
    def lost(self) -> float:
        """Travel that is rolled but not travelled in the whole crossing, 2 r (q - sin q) [m]."""
        return 2.0 * self.reach * (self.half_angle - math.sin(self.half_angle))

    @property
    def rolled(self) -> float:
        """Travel that the wheel rolls in the whole crossing, 2 r q [m]."""
        return self.travelled + self.lost

    def lost_after(self, rolled: Array) -> Array:
        """Return the travel lost when so much of the crossing has been rolled, each `(K,)` [m].

        The centre swings from -q to s - q, s = rolled / r, and travels r (sin q + sin(s - q)).
        """
        swung = np.clip(np.asarray(rolled) / self.reach, 0.0, 2.0 * self.half_angle)
        sin = math.sin(self.half_angle)
        return np.asarray(self.reach * (swung - sin - np.sin(swung - self.half_angle)))


def crossing_of(shape: Shape, radius: float, height: float) -> Crossing:
    """Return the crossing of an obstacle of a shape and height h by a wheel of radius R > h [m].

    A shape is an "edge", with cos q = 1 - h / R; a "cable" of diameter h, with cos q = (R - h / 2) / (R + h /
    2); or a "chord", the sharp edge that loses what CLAPPER's approximation gives.
    """
    if shape == "chord":
        return crossing_with_loss(radius, chord_loss(radius, height))
    if shape == "edge":
        travelled = 2.0 * math.sqrt(2.0 * radius * height - height * height)
        return Crossing(radius, math.acos(1.0 - height / radius), travelled)
    reach = radius + 0.5 * height
    travelled = 2.0 * math.sqrt(2.0 * radius * height)
    return Crossing(reach, math.acos((radius - 0.5 * height) / reach), travelled)


@lru_cache(maxsize=1024)
def crossing_with_loss(radius: float, lost: float) -> Crossing:
    """Return the crossing of a sharp edge with a given lost travel > 0 [m], 2 R (q - sin q) = lost."""
    q = (3.0 * lost / radius) ** (1.0 / 3.0)  # q - sin q = q^3 / 6 to first order
    for _ in range(_NEWTON_STEPS):
        q -= (2.0 * radius * (q - math.sin(q)) - lost) / (2.0 * radius * (1.0 - math.cos(q)))
    return Crossing(radius, q, 2.0 * radius * math.sin(q))


def chord_loss(radius: float, height: float) -> float:
    """Return the travel lost on an edge of height h by CLAPPER's approximation [m], C (1)-(3).

    It is 2 (sqrt(2 R h) - sqrt(2 R h - h^2)) for a wheel of radius R.
    """
    return 2.0 * (math.sqrt(2.0 * radius * height) - math.sqrt(2.0 * radius * height - height * height))


def edge_loss(radius: float, height: float) -> float:
    """Return the travel lost on a sharp edge of a height [m] by a wheel of a radius [m], in metres."""
    return crossing_of("edge", radius, height).lost


def cable_loss(radius: float, height: float) -> float:
    """Return the travel lost on a round cable of a diameter [m] by a wheel of a radius [m], in metres."""
    return crossing_of("cable", radius, height).lost
