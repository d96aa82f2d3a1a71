"""Bumps: travel that a wheel loses when it rolls over an obstacle, and where the obstacles lie.

A wheel that climbs over something turns further than it travels. Three shapes: the approximation that
CLAPPER prints, the exact arc over an edge, and a round cable; 0.57 degrees per 10 mm cable at a
wheelbase of 340 mm, where 0.6 was measured (C 6.1).
"""

import math
from dataclasses import dataclass
from typing import Literal

from vcan_sim.errors import SimulationError
from vehicle.parameters import WHEELS, Channel

Shape = Literal["chord", "edge", "cable"]


def chord_loss(radius: float, height: float) -> float:
    """Return the travel lost on a bump [m], C (1)-(3): 2 (sqrt(2 R h) - sqrt(2 R h - h^2)).

    Args:
        radius: of the wheel [m].
        height: of the bump [m].
    """
    return 2.0 * (math.sqrt(2.0 * radius * height) - math.sqrt(2.0 * radius * height - height * height))


def edge_loss(radius: float, height: float) -> float:
    """Return the travel lost on a sharp edge [m].

    The wheel turns about the edge, up and down again: 2 R (q - sin q) with cos q = 1 - h/R.
    """
    q = math.acos(1.0 - height / radius)
    return 2.0 * radius * (q - math.sin(q))


def cable_loss(radius: float, height: float) -> float:
    """Return the travel lost on a round cable of a diameter [m].

    The wheel's centre moves on a circle of radius R + r about the cable's, r = h/2, from the touch at
    cos q = (R - r) / (R + r) on one side to that on the other: 2 (R + r) (q - sin q).
    """
    reach = radius + 0.5 * height
    q = math.acos((radius - 0.5 * height) / reach)
    return 2.0 * reach * (q - math.sin(q))


_LOSS = {"chord": chord_loss, "edge": edge_loss, "cable": cable_loss}


@dataclass(frozen=True, slots=True)
class Bump:
    """An obstacle, either put under one wheel or lying at a place of the floor.

    Attributes:
        height: or diameter of the cable [m].
        shape: which law of loss holds.
        wheel: under which it is put; None for an obstacle on the floor, which every wheel meets.
        after: travel of that wheel, since the lap began or since the start, at which it is met [m].
        lap: in which it is put there, from 0; None for the whole drive.
        x: of the obstacle on the floor [m].
        y: likewise [m].
        size: radius around x and y within which a wheel's contact point meets it [m].

    Raises:
        SimulationError: a wheel that is none, or a height or size that is not positive.
    """

    height: float = 0.010
    shape: Shape = "cable"
    wheel: Channel | None = None
    after: float = 0.0
    lap: int | None = None
    x: float = 0.0
    y: float = 0.0
    size: float = 0.05

    def __post_init__(self) -> None:
        if self.wheel is not None and self.wheel not in WHEELS:
            raise SimulationError(f"bump: {self.wheel!r} is no wheel; expected one of {', '.join(WHEELS)}")
        if self.shape not in _LOSS:
            raise SimulationError(f"bump: {self.shape!r} is no shape; expected one of {', '.join(_LOSS)}")
        if not (self.height > 0.0 and self.size > 0.0):
            raise SimulationError(f"bump: height {self.height} m, size {self.size} m; expected more than 0")

    def lost(self, radius: float) -> float:
        """Return the travel that a wheel of a radius [m] loses in one crossing [m].

        Raises:
            SimulationError: an obstacle that this wheel cannot climb.
        """
        if self.height >= radius:
            raise SimulationError(f"bump: {self.height} m is too high for a wheel of {radius} m radius")
        return _LOSS[self.shape](radius, self.height)

    def span(self, radius: float) -> float:
        """Return the rolled way of one crossing by a wheel of a radius [m], over which the loss is spread."""
        return 2.0 * math.sqrt(2.0 * radius * self.height) + self.lost(radius)


def bumps_under(
    wheel: Channel,
    count: int,
    start: float,
    end: float,
    *,
    lap: int | None = None,
    height: float = 0.010,
    shape: Shape = "cable",
) -> tuple[Bump, ...]:
    """Return bumps put under one wheel, evenly spaced between two travels of it [m], C 6.1 and O 3.1."""
    step = (end - start) / count
    places = [start + (number + 0.5) * step for number in range(count)]
    return tuple(Bump(height, shape, wheel, place, lap) for place in places)
