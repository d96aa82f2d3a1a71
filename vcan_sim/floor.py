"""The floor: how rough it is, and what lies on it."""

import math
from dataclasses import dataclass

from vcan_sim.bumps import Bump
from vcan_sim.errors import SimulationError

# [m/sqrt(m)] A wheel's travel over a metre of floor scatters by this much. With a wheelbase of 340 mm it
# makes the return position of a 4 x 4 m square scatter by 25 mm in x and in y, as U V reports: shown by
# `pytest tests/vcan_sim/test_floor.py`. The heading then scatters by 0.54 degrees.
CONCRETE = 5.6e-4


@dataclass(frozen=True, slots=True)
class Floor:
    """A floor.

    Attributes:
        roughness: standard deviation of a wheel's travel after one metre [m/sqrt(m)]; it grows with the
            square root of the travel, independently for each wheel (Chong & Kleeman, 1997).
        bumps: on it.

    Raises:
        SimulationError: a roughness that is negative or not finite.
    """

    roughness: float = CONCRETE
    bumps: tuple[Bump, ...] = ()

    def __post_init__(self) -> None:
        if not (math.isfinite(self.roughness) and self.roughness >= 0.0):
            raise SimulationError(f"roughness {self.roughness} m/sqrt(m); expected a finite number from 0")


SMOOTH = Floor(roughness=0.0)
