"""What the filter assumes before it has seen a sample: how well `vehicle.toml` is known, and the noise."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.vehicle.floor import CONCRETE_ROUGHNESS

if TYPE_CHECKING:
    from omnimate.vehicle.compiled import Array

SUSPECTED = (
    *("diameter of a.left", "diameter of a.right", "diameter of b.left", "diameter of b.right"),
    *("both diameters of a", "both diameters of b", "wheelbase of a", "wheelbase of b"),
    *("sideways creep of a", "sideways creep of b", "bias of joint_a", "bias of joint_b", "bias of link"),
    *("unequal diameters of a", "unequal diameters of b"),
)
"""What may be wrong with a robot's description."""
# Largest standard deviation of each: rubber tyres and their load, 1 %; the contact points of wide tyres, 3 %;
# a zero set by eye, 1 degree; a tape measure, 10 mm; the sideways speed of a rubber tyre per acceleration.
SIZES = (0.01,) * 6 + (0.03,) * 2 + (0.05,) * 2 + (math.radians(1.0),) * 2 + (0.01,) + (0.01,) * 2
SMALLEST = 1e-6  # of a standard deviation: an exact value would leave nothing to invert
OPEN = (0.03,) * 4 + (0.1,) * 2 + (0.2,) * 2 + (math.radians(3.0),) * 2 + (0.03,)


@dataclass(frozen=True, slots=True)
class Prior:
    """Standard deviations of the values in `vehicle.toml` where nothing is wrong, and how often something is.

    They are small: most robots are as described as far as a drive can tell, and what is not is told by the
    readings. The linkage cannot show the mean of all wheel diameters.

    Attributes:
        scale: Relative standard deviation of the mean of a truck's wheel diameters, U (2.4) E_s.
        ratio: Standard deviation of a truck's right over left wheel diameter, U (2.3) E_d.
        wheelbase: Relative standard deviation of each truck's wheelbase, U (2.4) E_b.
        joint: Standard deviation of the bias of each joint [rad].
        link: Standard deviation of the bias of the link [m].
        creep: Standard deviation of a truck's sideways speed per lateral acceleration [s].
        wrong: Probability that a given one of `SUSPECTED` is wrong.
    """

    scale: float = 1e-4
    ratio: float = 1.5e-4
    wheelbase: float = 5e-4
    joint: float = math.radians(0.003)
    link: float = 2e-4
    creep: float = 1e-3
    wrong: float = 0.05

    @property
    def covariance(self) -> Array:
        """Covariance of wheels, wheelbases, creep, joint biases and link bias if all is well, `(11, 11)`."""
        each = [0.0] * 4 + [self.wheelbase] * 2 + [self.creep] * 2 + [self.joint] * 2 + [self.link]
        out = np.diag(np.square(np.maximum(each, SMALLEST)))
        together, apart = max(self.scale, SMALLEST) ** 2, 0.25 * max(self.ratio, SMALLEST) ** 2
        truck = [[together + apart, together - apart], [together - apart, together + apart]]
        out[:2, :2] = out[2:4, 2:4] = truck
        return out

    @property
    def odds(self) -> float:
        """Logarithm of the odds that a given one of `SUSPECTED` is wrong."""
        return math.log(self.wrong / (1.0 - self.wrong))


def directions() -> Array:
    """Return the direction of each of `SUSPECTED` in the slow states, shape `(15, 11)`."""
    out = np.zeros((15, 11))
    out[:4, :4] = np.eye(4)
    out[4, :2] = out[5, 2:4] = 1.0
    out[6:13, 4:] = np.eye(7)
    out[13, :2], out[14, 2:4] = (-0.5, 0.5), (-0.5, 0.5)
    return out


CALIBRATED = Prior()
"""A robot that was calibrated: one value in twenty is wrong by now."""
NOMINAL = Prior(wrong=0.2)
"""A robot as its data sheet describes it: one value in five is wrong."""
WATCHED = Prior(1e-3, 5e-4, 2e-2, math.radians(0.02), 3e-4, wrong=1e-6)
"""What tyres change from day to day, each value a little: to watch values, and not for a pose."""


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
