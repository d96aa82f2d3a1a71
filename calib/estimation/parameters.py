"""The unknowns of an estimation: coordinates of the parameters, and sources of noise."""

from __future__ import annotations

from typing import NamedTuple


class Coordinate(NamedTuple):
    """One parameter that a calibration may estimate.

    Attributes:
        name: Name for tables.
        unit: Unit of the coordinate: "1" for the logarithm of a factor, else rad, m or s.
        prior_sigma: Standard deviation to which the coordinate is known before any drive. A drive with a
            larger bound adds no knowledge.
    """

    name: str
    unit: str
    prior_sigma: float


class NoiseSource(NamedTuple):
    """One source of noise whose standard deviation may be estimated.

    Attributes:
        name: Name for tables.
        unit: Unit of the standard deviation.
        guess: Standard deviation at which the estimation begins.
    """

    name: str
    unit: str
    guess: float
