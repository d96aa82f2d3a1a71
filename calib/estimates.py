"""The result of an estimation: coordinates with their bound, the noise, and what was held or not believed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import t

if TYPE_CHECKING:
    from calib.kinematics import Coordinate, Noise
    from calib.observability import Held
    from vehicle.se2 import Array


@dataclass(frozen=True, slots=True)
class DownWeighted:
    """A fix that the others contradict.

    Attributes:
        source: of the drive.
        time: of the fix [s].
        distance: from what all others predict, in standard deviations.
        weight: 0 to 1.
    """

    source: str
    time: float
    distance: float
    weight: float


@dataclass(frozen=True, slots=True)
class NoiseEstimate:
    """The standard deviation of one kind of noise.

    Attributes:
        noise: which.
        value: in its unit.
        freedom: degrees of freedom of its estimate; 0 where the data hold too few and the guess stands.
    """

    noise: Noise
    value: float
    freedom: float


@dataclass(frozen=True, slots=True)
class Estimate:
    """What the data say about a problem's coordinates.

    Attributes:
        names: the coordinates.
        coordinates: (P,) estimated; 0 where held.
        covariance: (P, P) their Cramer-Rao bound with the noise estimated; 0 where held.
        held: coordinates that the data do not tell, and those held by request.
        condition: number of the free coordinates' information, each scaled by its doubt.
        noises: of the movements, then of the fixes.
        freedom: degrees of freedom for intervals.
        down_weighted: fixes that the others contradict, worst first.
        fixes: how many measured poses there are.
        rms: of the whitened residuals; 1 where the noise is described well.
    """

    names: tuple[Coordinate, ...]
    coordinates: Array
    covariance: Array
    held: tuple[Held, ...]
    condition: float
    noises: tuple[NoiseEstimate, ...]
    freedom: float
    down_weighted: tuple[DownWeighted, ...]
    fixes: int
    rms: float

    @property
    def sigma(self) -> Array:
        """Standard deviations `(P,)` of the coordinates."""
        return np.sqrt(np.diag(self.covariance))

    def half_width(self, confidence: float = 0.95) -> float:
        """Return how many standard deviations make an interval of this confidence."""
        return float(t.ppf(0.5 + 0.5 * confidence, max(self.freedom, 1.0)))
