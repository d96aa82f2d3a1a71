"""The form of every least-squares calibration: chains of measured poses, and movements between them."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from omnimate.calib.estimation.filtering import Filtered, Smoothed, filter_chains, smooth_chains

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from omnimate.vehicle.se2 import Array


class Chains(NamedTuple):
    """M measured poses of one or more chains, one after the other, at given coordinates `(P,)`.

    Each pose follows from the one before it: pose = left (+) pose before (+) right.
    """

    first: NDArray[np.bool_]  # whether a chain begins with this pose, `(M,)`
    start: Array  # approximate pose at which a chain begins, `(M, 3)`
    left: Array  # increment on the left of the pose before, `(M, 3)`
    right: Array  # increment on the right of the pose before, `(M, 3)`
    sensitivity: Array  # derivative of the movement by the coordinates, body frame at its end, `(M, 3, P)`
    process: Array  # its covariance per unit variance of each of C noises, the same frame, `(C, M, 3, 3)`
    measured: Array  # measured poses; nan where unknown, `(M, 3)`
    stated: Array  # known part of the covariance of the measured poses, world frame, `(M, 3, 3)`
    scatter: Array  # covariance of `measured` per unit variance of each of K noises, world, `(K, M, 3, 3)`
    lever: Array  # pose of the reference on the robot, `(3,)`
    effect: Array  # derivative of the reference's pose by the coordinates, body frame, `(M, 3, P)`

    def filtered(self, variances: Array, weights: Array) -> tuple[Filtered, Smoothed]:
        """Return the filter's results for the variances of all noises and the weights `(M,)` of the fixes."""
        first = self.first.astype(np.float64)
        process = np.tensordot(variances[: len(self.process)], self.process, 1)
        noise = self.noise(variances) / weights[:, np.newaxis, np.newaxis]
        moved = self.start, self.left, self.right, self.sensitivity, process
        ahead = Filtered(*filter_chains(first, *moved, self.measured, noise, self.lever, self.effect))
        return ahead, Smoothed(*smooth_chains(first, self.lever, *ahead[:4]))

    def noise(self, variances: Array) -> Array:
        """Return the covariance `(M, 3, 3)` of each measured pose, world frame."""
        scattered = np.tensordot(variances[len(self.process) :], self.scatter, 1)
        return np.asarray(self.stated + scattered, np.float64)


class Problem(Protocol):
    """A calibration problem: parameters, and the chains that they predict."""

    @property
    def source(self) -> str:
        """Files or folders that the data come from."""

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The coordinates that may be estimated; 0 is nominal."""

    @property
    def noises(self) -> tuple[NoiseSource, ...]:
        """The sources of noise: first those of `Chains.process`, then those of `Chains.scatter`."""

    def chains(self, coordinates: Array) -> Chains:
        """Return the chains at coordinates `(P,)`."""

    def fixes(self) -> list[tuple[str, float]]:
        """Return the source and the time [s] of each measured pose, in the order of the chains."""


def concatenate_chains(chains: list[Chains], lever: Array) -> Chains:
    """Return chains one after the other."""
    axes = {"process": 1, "scatter": 1}
    joined = {
        name: np.concatenate([getattr(chain, name) for chain in chains], axis=axes.get(name, 0))
        for name in Chains._fields
        if name != "lever"
    }
    return Chains(**joined, lever=lever)


class Coordinate(NamedTuple):
    """One parameter that a calibration may estimate."""

    name: str  # for tables
    unit: str  # unit of the coordinate: "1" for the logarithm of a factor, else rad, m or s
    prior_sigma: float  # standard deviation before any drive; a drive with a larger bound adds no knowledge


class NoiseSource(NamedTuple):
    """One source of noise whose standard deviation may be estimated."""

    name: str  # for tables
    unit: str  # unit of the standard deviation
    guess: float  # standard deviation at which the estimation begins
