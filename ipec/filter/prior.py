"""How well `vehicle.toml` is known before the filter has seen a sample."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from omnimate.vehicle.compiled import Array


@dataclass(frozen=True, slots=True)
class Prior:
    """Standard deviations of the values in `vehicle.toml`.

    The linkage cannot show the mean of all wheel diameters, and it cannot show the joints' biases as long as
    the trucks drive straight. These stay as uncertain as the prior says.

    Attributes:
        scale: Relative standard deviation of the mean of a truck's wheel diameters, U (2.4) E_s.
        ratio: Standard deviation of a truck's right over left wheel diameter, U (2.3) E_d.
        wheelbase: Relative standard deviation of each truck's wheelbase, U (2.4) E_b.
        joint: Standard deviation of the bias of each joint [rad].
        link: Standard deviation of the bias of the link [m].
    """

    scale: float = 1e-3
    ratio: float = 3e-4
    wheelbase: float = 1.5e-3
    joint: float = math.radians(0.02)
    link: float = 3e-4

    @property
    def covariance(self) -> Array:
        """Covariance of four wheels, two wheelbases, two joint biases and the link bias, shape `(9, 9)`."""
        out = np.diag(np.square([0.0] * 4 + [self.wheelbase] * 2 + [self.joint] * 2 + [self.link]))
        together, apart = self.scale**2, 0.25 * self.ratio**2
        truck = [[together + apart, together - apart], [together - apart, together + apart]]
        out[:2, :2] = out[2:4, 2:4] = truck
        return out


CALIBRATED = Prior()
"""What a calibration leaves uncertain."""
NOMINAL = Prior(5e-3, 5e-3, 2e-2, math.radians(0.5), 3e-3)
"""What a data sheet leaves uncertain."""
