"""What every least-squares calibration is made of: chains of measured poses, and movements between them."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from calib.filtering import Filtered, Smoothed, backwards, forwards

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from calib.kinematics import Coordinate, Noise
    from vehicle.se2 import Array


class Chains(NamedTuple):
    """M measured poses of one or more chains at some coordinates `(P,)`, one after the other.

    Attributes:
        first: (M,) True where a chain begins.
        start: (M, 3) where it begins, roughly.
        left: (M, 3) pose = left (+) pose before (+) right.
        right: (M, 3) likewise.
        sensitivity: (M, 3, P) derivative of the movement, body frame at its end.
        process: (C, M, 3, 3) covariance of the movement per unit variance, likewise.
        measured: (M, 3) nan where unknown.
        stated: (M, 3, 3) known part of its covariance, world frame.
        scatter: (K, M, 3, 3) parts of unknown size, per unit variance, world frame.
        lever: (3,) pose of the reference on the robot.
        effect: (M, 3, P) derivative of the reference's pose, body frame.
    """

    first: NDArray[np.bool_]
    start: Array
    left: Array
    right: Array
    sensitivity: Array
    process: Array
    measured: Array
    stated: Array
    scatter: Array
    lever: Array
    effect: Array

    def filtered(self, variances: Array, weights: Array) -> tuple[Filtered, Smoothed]:
        """Return the filter's results for the variances of all noises and the weights `(M,)` of the fixes."""
        first = self.first.astype(np.float64)
        process = np.tensordot(variances[: len(self.process)], self.process, 1)
        noise = self.noise(variances) / weights[:, np.newaxis, np.newaxis]
        moved = self.start, self.left, self.right, self.sensitivity, process
        ahead = Filtered(*forwards(first, *moved, self.measured, noise, self.lever, self.effect))
        return ahead, Smoothed(*backwards(first, self.lever, *ahead[:4]))

    def noise(self, variances: Array) -> Array:
        """Return the covariance `(M, 3, 3)` of each measured pose, world frame."""
        scattered = np.tensordot(variances[len(self.process) :], self.scatter, 1)
        return np.asarray(self.stated + scattered, np.float64)


class Problem(Protocol):
    """A calibration: parameters, and the chains that they predict."""

    @property
    def source(self) -> str:
        """Where the data came from."""

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """What may be estimated; 0 is nominal."""

    @property
    def noises(self) -> tuple[Noise, ...]:
        """First those of `Chains.process`, then those of `Chains.scatter`."""

    def chains(self, coordinates: Array) -> Chains:
        """Return the chains at coordinates `(P,)`."""

    def place(self, number: int) -> tuple[str, float]:
        """Return the source and the time [s] of a measured pose."""


def joined(chains: list[Chains], lever: Array) -> Chains:
    """Return chains one after the other."""
    return Chains(
        first=np.concatenate([one.first for one in chains]),
        start=np.concatenate([one.start for one in chains]),
        left=np.concatenate([one.left for one in chains]),
        right=np.concatenate([one.right for one in chains]),
        sensitivity=np.concatenate([one.sensitivity for one in chains]),
        process=np.concatenate([one.process for one in chains], axis=1),
        measured=np.concatenate([one.measured for one in chains]),
        stated=np.concatenate([one.stated for one in chains]),
        scatter=np.concatenate([one.scatter for one in chains], axis=1),
        lever=lever,
        effect=np.concatenate([one.effect for one in chains]),
    )
