"""The result of an estimation: coordinates with their bound, noise, held coordinates, rejected fixes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.calib.distributions import student_quantile

if TYPE_CHECKING:
    from omnimate.calib.estimation.chains import Coordinate, NoiseSource
    from omnimate.calib.estimation.observability import Held
    from omnimate.vehicle.se2 import Array


@dataclass(frozen=True, slots=True)
class DownWeighted:
    """An outlier among the fixes."""

    source: str  # name of the drive
    time: float  # time of the fix [s]
    distance: float  # distance from the prediction by all others [standard deviations]
    weight: float  # weight of the fix in the estimation, from 0 to 1


@dataclass(frozen=True, slots=True)
class NoiseLevel:
    """The estimated standard deviation of one source of noise."""

    source: NoiseSource
    value: float  # standard deviation in the unit of the source
    freedom: float  # degrees of freedom of the estimate; 0 where the data hold too few and the guess is kept


@dataclass(frozen=True, slots=True)
class Estimate:
    """Estimated coordinates of a problem with P coordinates."""

    parameters: tuple[Coordinate, ...]  # names, units and prior standard deviations of the coordinates
    coordinates: Array  # estimated values of the coordinates, `(P,)`; 0 where held
    covariance: Array  # Cramer-Rao bound of the coordinates with the estimated noise, `(P, P)`; 0 where held
    held: tuple[Held, ...]  # coordinates that the data do not identify, or that were held by request
    condition: float  # condition number of the information on the free coordinates, in units of the prior
    noises: tuple[NoiseLevel, ...]  # estimated noise of the movements, then of the fixes
    freedom: float  # degrees of freedom for confidence intervals
    down_weighted: tuple[DownWeighted, ...]  # outliers among the fixes, the worst first
    fixes: int  # number of measured poses
    rms: float  # root mean square of the whitened residuals; 1 if the noise model fits

    @property
    def sigma(self) -> Array:
        """Standard deviations `(P,)` of the coordinates."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def half_width(self) -> float:
        """Half the width of a 95 % interval, in standard deviations."""
        return student_quantile(0.975, max(self.freedom, 1.0))
