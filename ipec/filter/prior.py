"""Prior of the filter: uncertainty of the values in `vehicle.toml`, and noise levels."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.vehicle.floor import CONCRETE_ROUGHNESS

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from omnimate.vehicle.compiled import Array

SUSPECT_NAMES = (
    *("diameter of a.left", "diameter of a.right", "diameter of b.left", "diameter of b.right"),
    *("both diameters of a", "both diameters of b", "unequal diameters of a", "unequal diameters of b"),
    *("wheelbase of a", "wheelbase of b", "sideways creep of a", "sideways creep of b"),
    *("unequal diameters of both trucks", "sideways creep of both trucks"),
    *("bias of joint_a", "bias of joint_b", "bias of link"),
)
"""Parameters of `vehicle.toml` that may be wrong, alone, or alike in both trucks by one cause: a load that
leans to a side, or tyres of one kind."""
VALUE_NAMES = (
    *("diameters of a", "diameters of b", "wheelbase of a", "wheelbase of b"),
    *("sideways creep of a", "sideways creep of b", "bias of joint_a", "bias of joint_b", "bias of link"),
)
"""What a suspect changes. Several suspects may change one of them with nearly the same readings."""
# Largest standard deviation of each suspect. Assumptions: rubber tyres and their load, 1 %; the contact
# points of wide tyres, 3 %; sideways speed of a rubber tyre per lateral acceleration, 0.05 s; a zero set by
# eye, 1 degree; a tape measure, 10 mm.
DIAMETER, BASE, CREEP, ZERO = 0.01, 0.03, 0.05, math.radians(1.0)
SUSPECT_SIZES = (*(DIAMETER,) * 8, BASE, BASE, CREEP, CREEP, DIAMETER, CREEP, ZERO, ZERO, 0.01)
MIN_SIGMA = 1e-6  # smallest standard deviation of the prior, so that its covariance can be inverted
# Prior of the open filter: a few times `SUSPECT_SIZES`, so that the data alone determine its slow states.
OPEN_SIGMAS = (0.03,) * 4 + (0.1,) * 2 + (0.2,) * 2 + (math.radians(3.0),) * 2 + (0.03,)


@dataclass(frozen=True, slots=True)
class Prior:
    """Standard deviations of correct values in `vehicle.toml`, and the probability that one is wrong.

    The standard deviations are small: wrong values are separate suspects, which the readings identify. The
    mean of all wheel diameters cannot be observed by the linkage.
    """

    scale: float = 1e-4  # relative standard deviation of the mean of a truck's wheel diameters, U (2.4) E_s
    ratio: float = 1.5e-4  # standard deviation of a truck's right over left wheel diameter, U (2.3) E_d
    wheelbase: float = 5e-4  # relative standard deviation of each truck's wheelbase, U (2.4) E_b
    joint: float = math.radians(0.003)  # standard deviation of the bias of each joint [rad]
    link: float = 2e-4  # standard deviation of the bias of the link [m]
    creep: float = 1e-3  # standard deviation of a truck's sideways speed per lateral acceleration [s]
    wrong: float = 0.05  # probability that a given one of `SUSPECT_NAMES` is wrong

    @property
    def covariance(self) -> Array:
        """Covariance of wheels, wheelbases, creep, joint biases and link bias, `(11, 11)`."""
        sigmas = [0.0] * 4 + [self.wheelbase] * 2 + [self.creep] * 2 + [self.joint] * 2 + [self.link]
        out = np.diag(np.square(np.maximum(sigmas, MIN_SIGMA)))
        together, apart = max(self.scale, MIN_SIGMA) ** 2, 0.25 * max(self.ratio, MIN_SIGMA) ** 2
        truck = [[together + apart, together - apart], [together - apart, together + apart]]
        out[:2, :2] = out[2:4, 2:4] = truck
        return out

    @property
    def odds(self) -> float:
        """Logarithm of the odds that a given one of `SUSPECT_NAMES` is wrong."""
        return math.log(self.wrong / (1.0 - self.wrong))


def suspect_directions() -> Array:
    """Return the direction of each of `SUSPECT_NAMES` in the slow states, shape `(17, 11)`."""
    out = np.zeros((len(SUSPECT_NAMES), 11))
    out[:4, :4] = np.eye(4)
    out[4, :2] = out[5, 2:4] = 1.0
    out[6, :2] = out[7, 2:4] = out[12, :2] = out[12, 2:4] = -0.5, 0.5
    out[8:12, 4:8] = np.eye(4)
    out[13, 6:8] = 1.0
    out[14:, 8:] = np.eye(3)
    return out


def suspect_values() -> NDArray[np.bool_]:
    """Return whether each of `SUSPECT_NAMES` changes each of `VALUE_NAMES`, shape `(17, 9)`."""
    changed = suspect_directions() != 0.0
    return np.column_stack([changed[:, :2].any(axis=1), changed[:, 2:4].any(axis=1), changed[:, 4:]])


CALIBRATED = Prior()
"""A robot that was calibrated: one value in twenty is wrong by now (assumption)."""
NOMINAL = Prior(wrong=0.2)
"""A robot described by its data sheet: one value in five is wrong (assumption)."""
MONITORING_PRIOR = Prior(1e-3, 5e-4, 2e-2, math.radians(0.02), 3e-4, wrong=1e-6)
"""Day-to-day changes of all values, for the monitoring of parameters and not for poses."""


@dataclass(frozen=True, slots=True)
class FilterNoise:
    """Initial noise levels of the filter, and the limits of its test for disturbances."""

    roughness: float = CONCRETE_ROUGHNESS  # sigma of a wheel's travel after one metre [m/sqrt(m)]
    sideways: float = 5e-5  # sigma of a truck's sideways slip after one metre [m/sqrt(m)]
    slack: float = 1e-4  # sigma of unexplained changes of the link's length after one metre [m/sqrt(m)]
    correlated: float = 0.2  # correlation length of the errors of floor and wheels [m]
    trust: float = 4.0  # distance that the initial levels count for against learned ones [m]
    memory: float = 20.0  # distance over which learned levels are forgotten exponentially [m]
    drift: float = 1e-5  # sigma of the change of a wheel's or wheelbase's factor in one metre [1/sqrt(m)]
    gate: float = 3.5  # innovation above which an input is tested for a disturbance [standard deviations]
    hold: float = 0.1  # travel for which a disturbed input stays distrusted [m]
    distrust: float = 0.1  # sigma of a distrusted input, as a fraction of the distance rolled
