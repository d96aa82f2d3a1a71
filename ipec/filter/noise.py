"""How much the floor and the encoders scatter, as the filter assumes it."""

from __future__ import annotations

from dataclasses import dataclass

from omnimate.vehicle.floor import CONCRETE_ROUGHNESS


@dataclass(frozen=True, slots=True)
class FilterNoise:
    """The noise that the filter expects until it has learned it, and the limits of its test for disturbances.

    Attributes:
        roughness: Standard deviation of a wheel's travel after one metre [m/sqrt(m)].
        sideways: Standard deviation of a truck's sideways slip after one metre [m/sqrt(m)].
        slack: Standard deviation of what the link changes its length by for no reason [m/sqrt(m)].
        correlated: Way over which the errors of a floor and of a wheel are alike [m].
        trust: Way for which these three count [m].
        memory: Way after which what was learned of them has faded [m].
        drift: Standard deviation of the change of a wheel's or a wheelbase's factor in one metre [1/sqrt(m)].
        gate: Size of an innovation from which on an input counts as disturbed [standard deviations].
        hold: Travel for which a disturbed input stays distrusted [m].
        distrust: Standard deviation of a distrusted input, as a fraction of what was rolled.
    """

    roughness: float = CONCRETE_ROUGHNESS
    sideways: float = 5e-5
    slack: float = 1e-4
    correlated: float = 0.2
    trust: float = 4.0
    memory: float = 20.0
    drift: float = 1e-5
    gate: float = 3.5
    hold: float = 0.1
    distrust: float = 0.1
