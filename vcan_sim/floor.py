"""The floor: its roughness and its bumps."""

import math
from dataclasses import dataclass
from functools import partial
from typing import Any, cast

from omnimate.effects.crossing import SHAPES, Crossing, Shape, crossing_of
from omnimate.vcan_sim.errors import BumpError, SimulationError
from omnimate.vcan_sim.key_values import INTEGER, NUMBER, TEXT, Kind, read_values
from omnimate.vehicle.floor import CONCRETE_ROUGHNESS
from omnimate.vehicle.parameters import WHEELS, Channel

_KINDS: dict[str, Kind] = {
    "wheel": TEXT,
    "after": NUMBER,
    "lap": INTEGER,
    "x": NUMBER,
    "y": NUMBER,
    "size": NUMBER,
    "height": NUMBER,
    "shape": TEXT,
}


@dataclass(frozen=True, slots=True)
class Bump:
    """An obstacle, either put under one wheel or lying at a place of the floor.

    Raises:
        SimulationError: The wheel or the shape is not known, or height or size is not positive.
    """

    height: float = 0.010  # height of the obstacle, or diameter of the cable [m]
    shape: Shape = "cable"  # shape of the obstacle: "cable", "edge" or CLAPPER's approximation "chord"
    # wheel under which the obstacle is put; None for an obstacle on the floor, for every wheel that passes
    # there
    wheel: Channel | None = None
    # travel of that wheel at which it encounters the obstacle, since the lap began or, without a lap, since
    # the start [m]
    after: float = 0.0
    # number of the lap in which the obstacle is put there, from 0; None for the whole drive
    lap: int | None = None
    x: float = 0.0  # place of the obstacle on the floor, x [m]
    y: float = 0.0  # place of the obstacle on the floor, y [m]
    # radius around x and y within which a wheel's contact point encounters the obstacle [m]
    size: float = 0.05

    def __post_init__(self) -> None:
        if self.wheel is not None and self.wheel not in WHEELS:
            raise SimulationError(f"a bump under {self.wheel!r}; expected one of {', '.join(WHEELS)}")
        if self.shape not in SHAPES:
            raise SimulationError(f"a bump of the shape {self.shape!r}; expected one of {', '.join(SHAPES)}")
        if not (self.height > 0.0 and self.size > 0.0):
            raise SimulationError(
                f"a bump of height {self.height} m and size {self.size} m; expected more than 0"
            )

    def crossing(self, radius: float) -> Crossing:
        """Return how a wheel of a radius [m] crosses the obstacle; raises SimulationError if too high."""
        if self.height >= radius:
            raise SimulationError(
                f"a bump of {self.height} m is too high; expected less than the radius {radius} m"
            )
        return crossing_of(self.shape, radius, self.height)


def bumps_under(
    wheel: Channel, count: int, start: float, end: float, *, lap: int | None = None, height: float = 0.010
) -> tuple[Bump, ...]:
    """Return cables put under one wheel, evenly spaced between two travels of it [m], C 6.1 and O 3.1."""
    step = (end - start) / count
    places = [start + (number + 0.5) * step for number in range(count)]
    return tuple(Bump(height, wheel=wheel, after=place, lap=lap) for place in places)


def parse_bump(text: str) -> Bump:
    """Return the bump that a text such as `wheel=a.right,after=3,height=0.01` describes; raises BumpError."""
    if not text:
        raise BumpError(text, f"expected key=value with {', '.join(_KINDS)}")
    values = read_values(text, _KINDS, partial(BumpError, text))
    try:
        return Bump(**cast("dict[str, Any]", values))
    except SimulationError as error:
        raise BumpError(text, str(error)) from error


@dataclass(frozen=True, slots=True)
class Floor:
    """A floor.

    Raises:
        SimulationError: The roughness is negative or not finite.
    """

    # standard deviation of a wheel's travel after one metre [m/sqrt(m)]; it grows with the square root of the
    # travel, independently for each wheel (Chong & Kleeman, 1997)
    roughness: float = CONCRETE_ROUGHNESS
    bumps: tuple[Bump, ...] = ()  # obstacles on the floor

    def __post_init__(self) -> None:
        if not (math.isfinite(self.roughness) and self.roughness >= 0.0):
            raise SimulationError(f"roughness {self.roughness} m/sqrt(m); expected a finite number from 0")


SMOOTH = Floor(roughness=0.0)
