"""The problem of two trucks on a linkage: what its encoders read against what the wheels turned.

The pose of truck b in the frame of truck a is z = (L, joint_a, joint_b) in other words. From one reading to
the next it is taken along by both trucks: after = inverse(moved_a) (+) before (+) moved_b. Nothing else is
needed, and no path is integrated. Where both trucks were measured from outside at the same time, their
relative pose is one more reading, without the linkage's biases: a loop closure.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from calib.chains import Chains, joined
from calib.filtering import accumulate
from calib.kinematics import ROUGHNESS, Coordinate, Differential, Noise
from vehicle.linkage import follower
from vehicle.se2 import inverse

if TYPE_CHECKING:
    from calib.kinematics import Steps
    from calib.linkage_drive import LinkageDrive
    from vehicle.parameters import Truck
    from vehicle.se2 import Array

# What the two trucks have in common the linkage tells worse than what they differ by.
COORDINATES = (
    Coordinate("wheelbase, both", "1", 0.05),
    Coordinate("mean diameter (E_s), both", "1", 0.002),
    Coordinate("diameter ratio (E_d), both", "1", 0.005),
    Coordinate("wheelbase, a against b", "1", 0.05),
    Coordinate("mean diameter (E_s), a against b", "1", 0.002),
    Coordinate("diameter ratio (E_d), a against b", "1", 0.005),
    Coordinate("joint bias, both", "rad", 0.035),
    Coordinate("joint bias, a against b", "rad", 0.035),
    Coordinate("link bias", "m", 0.01),
)
BIASES = tuple(one.name for one in COORDINATES[6:])
JOINT = Noise("joint reading", "rad", 2e-4)
LINK = Noise("link reading", "m", 2e-4)
# (9, 9): coordinates above -> those of truck a, of truck b, and joint_a, joint_b, link
SEPARATE = np.eye(9)
SEPARATE[:6, :6] = np.kron(np.array([[1.0, 0.5], [1.0, -0.5]]), np.eye(3))
SEPARATE[6:8, 6:8] = [[1.0, 0.5], [1.0, -0.5]]


@dataclass(frozen=True, slots=True)
class LinkageProblem:
    """Drives of one robot with a linkage.

    Attributes:
        drives: each one chain.
        trucks: a and b, nominal.
    """

    drives: tuple[LinkageDrive, ...]
    trucks: tuple[Truck, Truck]

    @property
    def source(self) -> str:
        """Where the data came from."""
        return ", ".join(dict.fromkeys(drive.source for drive in self.drives))

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Of both trucks, what they have in common and what they differ by, then the biases."""
        return COORDINATES

    @property
    def noises(self) -> tuple[Noise, ...]:
        """The floor's roughness, and what the linkage's encoders scatter beyond their resolution."""
        return (ROUGHNESS, JOINT, LINK)

    def place(self, number: int) -> tuple[str, float]:
        """Return the drive and the time [s] of a reading."""
        for drive in self.drives:
            if number < len(drive.time):
                return drive.source, float(drive.time[number])
            number -= len(drive.time)
        raise IndexError(number)

    def values(self, coordinates: Array) -> dict[str, float]:
        """Return the robot's parameters in SI units."""
        apart = SEPARATE @ coordinates
        result: dict[str, float] = {}
        for name, truck, own in zip("ab", self.trucks, (apart[:3], apart[3:6]), strict=True):
            found = Differential(truck).values(own)
            result |= {f"truck {name} {key}": value for key, value in found.items()}
        biases = zip(("joint_a bias", "joint_b bias", "link bias"), apart[6:], strict=True)
        return result | {name: float(value) for name, value in biases}

    def chains(self, coordinates: Array) -> Chains:
        """Return one chain per drive, after each other."""
        apart = SEPARATE @ coordinates
        return joined([self._chain(drive, apart) for drive in self.drives], np.zeros(3))

    def _chain(self, drive: LinkageDrive, apart: Array) -> Chains:
        count = len(drive.time)
        models = [Differential(truck) for truck in self.trucks]
        moved_a, slope_a, process_a = _moved(drive, models[0].steps(drive.wheels[:, :2], apart[:3]))
        moved_b, slope_b, process_b = _moved(drive, models[1].steps(drive.wheels[:, 2:], apart[3:6]))
        measured, slopes = _relative(drive, apart[6:])
        carry = _carried(measured)  # errors of a, seen from b, and with the other sign
        sensitivity = np.zeros((count, 3, 9))
        sensitivity[:, :, :3], sensitivity[:, :, 3:6] = -carry @ slope_a, slope_b
        effect = np.zeros((count, 3, 9))
        effect[:, :, 6:] = _into_body(slopes, measured[:, 2])
        first = np.zeros(count, np.bool_)
        first[0] = True
        return Chains(
            first=first,
            start=measured,
            left=np.asarray(inverse(moved_a), np.float64),
            right=moved_b,
            sensitivity=sensitivity @ SEPARATE,
            process=carry @ process_a @ carry.transpose(0, 2, 1) + process_b,
            measured=measured,
            stated=_stated(drive, slopes),
            scatter=_scatter(slopes),
            lever=np.zeros(3),
            effect=effect @ SEPARATE,
        )


def _moved(drive: LinkageDrive, steps: Steps) -> tuple[Array, Array, Array]:
    """Return a truck's movements before each reading; see `accumulate`."""
    ends = drive.ends.astype(np.float64)
    return accumulate(np.concatenate((ends[:1], ends[:-1])), ends, *steps)


def _relative(drive: LinkageDrive, biases: Array) -> tuple[Array, Array]:
    """Return truck b seen from a `(M, 3)`, and how far a bias shifts it, `(M, 3, 3)`, 0 where none acts."""
    joint_a, joint_b, length = (drive.linkage - biases).T
    read = follower(np.zeros(3), joint_a, joint_b, length)
    cos, sin, zero, one = np.cos(joint_a), np.sin(joint_a), np.zeros(len(length)), np.ones(len(length))
    by_a = np.stack([length * sin, length * cos, -one], axis=-1)
    by_b = np.stack([zero, zero, one], axis=-1)
    by_length = np.stack([-cos, sin, zero], axis=-1)
    slopes = np.stack([by_a, by_b, by_length], axis=-1)
    closed = drive.closed
    pose = np.where(closed[:, np.newaxis], drive.relative, read)
    return pose, np.where(closed[:, np.newaxis, np.newaxis], 0.0, slopes)


def _carried(pose: Array) -> Array:
    """Return how errors of truck a become errors seen from b `(M, 3, 3)`: Ad of the inverse pose."""
    carry = np.zeros((len(pose), 3, 3))
    cos, sin = np.cos(pose[:, 2]), np.sin(pose[:, 2])
    carry[:, 0, 0] = carry[:, 1, 1] = cos
    carry[:, 0, 1], carry[:, 1, 0] = sin, -sin
    carry[:, 0, 2] = sin * pose[:, 0] - cos * pose[:, 1]
    carry[:, 1, 2] = cos * pose[:, 0] + sin * pose[:, 1]
    carry[:, 2, 2] = 1.0
    return carry


def _into_body(columns: Array, heading: Array) -> Array:
    """Return columns `(M, 3, K)` of x, y, theta in frames at headings `(M,)`."""
    cos, sin = np.cos(heading)[:, np.newaxis], np.sin(heading)[:, np.newaxis]
    x, y = columns[:, 0], columns[:, 1]
    return np.stack([cos * x + sin * y, cos * y - sin * x, columns[:, 2]], axis=1)


def _stated(drive: LinkageDrive, slopes: Array) -> Array:
    """Return the covariances `(M, 3, 3)` that the resolution of the encoders makes, or that was stated."""
    read = slopes @ np.diag(drive.resolution**2 / 12.0) @ slopes.transpose(0, 2, 1)
    closed = drive.closed[:, np.newaxis, np.newaxis]
    return np.where(closed, drive.covariance, read + 1e-14 * np.eye(3))


def _scatter(slopes: Array) -> Array:
    """Return the covariances `(2, M, 3, 3)` per unit variance of the joints' and the link's scatter."""
    kinds = [np.diag([1.0, 1.0, 0.0]), np.diag([0.0, 0.0, 1.0])]
    return np.stack([slopes @ kind @ slopes.transpose(0, 2, 1) for kind in kinds])
