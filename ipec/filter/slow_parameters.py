"""What makes the encoders err, as the filter has estimated it: diameters, wheelbases and biases."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.ipec.filter.records import CREEP, JOINT_BIAS, LENGTH_BIAS, WHEEL, WHEELBASE

if TYPE_CHECKING:
    from omnimate.vehicle.compiled import Array


@dataclass(frozen=True, slots=True)
class SlowParameters:
    """The systematic errors of the encoders, as estimated.

    Attributes:
        wheel: True over nominal diameter of each wheel, minus 1, in the order of `WHEELS`, shape `(4,)`.
        wheelbase: True over nominal wheelbase of truck a and truck b, minus 1, shape `(2,)`.
        creep: Sideways speed of truck a and b per lateral acceleration, outwards [s], shape `(2,)`.
        joint_bias: What joint_a and joint_b read too much [rad], shape `(2,)`.
        link_bias: What the link reads too much [m].
        sigma: Standard deviations of wheels, wheelbases, creep, joint biases and link bias, `(11,)`.
    """

    wheel: Array
    wheelbase: Array
    creep: Array
    joint_bias: Array
    link_bias: float
    sigma: Array

    @property
    def vector(self) -> Array:
        """All of them in the order of `sigma`, shape `(11,)`."""
        return np.concatenate(
            [self.wheel, self.wheelbase, self.creep, self.joint_bias, [self.link_bias]], dtype=np.float64
        )


def slow_parameters(mean: Array, covariance: Array) -> SlowParameters:
    """Return the slow parameters in a filter's mean `(19,)` and covariance `(19, 19)`."""
    return SlowParameters(
        np.array(mean[WHEEL:WHEELBASE]),
        np.array(mean[WHEELBASE:CREEP]),
        np.array(mean[CREEP:JOINT_BIAS]),
        np.array(mean[JOINT_BIAS:LENGTH_BIAS]),
        float(mean[LENGTH_BIAS]),
        np.sqrt(np.diag(covariance))[WHEEL:],
    )
