"""The floor: its roughness and its bumps."""

import math
from dataclasses import dataclass

from omnimate.vcan_sim.bumps import Bump
from omnimate.vcan_sim.errors import SimulationError
from omnimate.vehicle.floor import CONCRETE_ROUGHNESS


@dataclass(frozen=True, slots=True)
class Floor:
    """A floor.

    Attributes:
        roughness: Standard deviation of a wheel's travel after one metre [m/sqrt(m)]; it grows with the
            square root of the travel, independently for each wheel (Chong & Kleeman, 1997).
        bumps: Obstacles on the floor.

    Raises:
        SimulationError: The roughness is negative or not finite.
    """

    roughness: float = CONCRETE_ROUGHNESS
    bumps: tuple[Bump, ...] = ()

    def __post_init__(self) -> None:
        if not (math.isfinite(self.roughness) and self.roughness >= 0.0):
            raise SimulationError(f"roughness {self.roughness} m/sqrt(m); expected a finite number from 0")


SMOOTH = Floor(roughness=0.0)
