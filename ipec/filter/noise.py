"""How much the floor and the encoders scatter, as the filter assumes it."""

from __future__ import annotations

from dataclasses import dataclass

from omnimate.vehicle.floor import CONCRETE_ROUGHNESS


@dataclass(frozen=True, slots=True)
class FilterNoise:
    """The noise that the filter assumes, with the limits of its test for disturbed wheels.

    Attributes:
        roughness: Standard deviation of a wheel's travel after one metre [m/sqrt(m)].
        sideways: Standard deviation of a truck's sideways slip after one metre [m/sqrt(m)].
        joint: Standard deviation of a joint's reading in addition to its resolution [rad].
        link: Standard deviation of the link's reading in addition to its resolution [m].
        drift: Standard deviation of the change of a wheel's or a wheelbase's factor in one metre [1/sqrt(m)].
        gate: Size of an innovation from which on a wheel counts as disturbed [standard deviations].
        hold: Travel for which a disturbed wheel stays distrusted [m].
        distrust: Standard deviation of a distrusted wheel's travel, as a fraction of what it rolled.
    """

    roughness: float = CONCRETE_ROUGHNESS
    sideways: float = 5e-5
    joint: float = 0.0
    link: float = 0.0
    drift: float = 1e-5
    gate: float = 3.0
    hold: float = 0.1
    distrust: float = 0.3
