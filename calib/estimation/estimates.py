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
    """An outlier among the fixes.

    Attributes:
        source: Name of the drive.
        time: Time of the fix [s].
        distance: Distance from the prediction by all others [standard deviations].
        weight: Weight of the fix in the estimation, from 0 to 1.
    """

    source: str
    time: float
    distance: float
    weight: float


@dataclass(frozen=True, slots=True)
class NoiseLevel:
    """The estimated standard deviation of one source of noise.

    Attributes:
        source: The source of noise.
        value: Standard deviation in the unit of the source.
        freedom: Degrees of freedom of the estimate; 0 where the data hold too few and the guess is kept.
    """

    source: NoiseSource
    value: float
    freedom: float


@dataclass(frozen=True, slots=True)
class Estimate:
    """Estimated coordinates of a problem with P coordinates.

    Attributes:
        parameters: Names, units and prior standard deviations of the coordinates.
        coordinates: Estimated values of the coordinates, shape `(P,)`; 0 where held.
        covariance: Cramer-Rao bound of the coordinates with the estimated noise, shape `(P, P)`; 0 where
            held.
        held: Coordinates that the data do not identify, or that were held by request.
        condition: Condition number of the information on the free coordinates, each in units of its prior
            standard deviation.
        noises: Estimated noise of the movements, then of the fixes.
        freedom: Degrees of freedom for confidence intervals.
        down_weighted: Outliers among the fixes, the worst first.
        fixes: Number of measured poses.
        rms: Root mean square of the whitened residuals; 1 if the noise model fits.
    """

    parameters: tuple[Coordinate, ...]
    coordinates: Array
    covariance: Array
    held: tuple[Held, ...]
    condition: float
    noises: tuple[NoiseLevel, ...]
    freedom: float
    down_weighted: tuple[DownWeighted, ...]
    fixes: int
    rms: float

    @property
    def sigma(self) -> Array:
        """Standard deviations `(P,)` of the coordinates."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def half_width(self) -> float:
        """Half the width of a 95 % interval, in standard deviations."""
        return student_quantile(0.975, max(self.freedom, 1.0))
