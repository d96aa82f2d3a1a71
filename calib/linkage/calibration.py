"""Calibration of the linkage, and of the trucks as far as the linkage identifies them, C 5.

C 5.1 mentions a calibration of the wheel diameters from the corrections that IPEC makes on a smooth floor.
These corrections are the difference between the readings of the linkage and the turns of the wheels; here all
parameters are fitted to them together, in increments from reading to reading, weighed by the noise of both.
Parameters that no reading of the linkage identifies stay nominal and are named. In particular, if both
diameter ratios are wrong by the same factor, the robot drives a curve that its joints show as a difference of
their biases, C 5.2: no drive without outside measurement separates these two.

The readings z = (L, joint_a, joint_b) are equivalent to the pose of truck b in the frame of truck a. From one
reading to the next, both trucks move it: after = inverse(moved_a) (+) before (+) moved_b. No path is
integrated. Where both trucks were measured from outside at the same time, their relative pose is another
reading, without the biases of the linkage: a loop closure.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from omnimate.calib.apply import corrected_vehicle
from omnimate.calib.errors import CalibrationError
from omnimate.calib.estimation.chains import Chains, Coordinate, NoiseSource, concatenate_chains
from omnimate.calib.estimation.filtering import join_steps
from omnimate.calib.estimation.search import estimate
from omnimate.calib.linkage.drive import linkage_drive
from omnimate.calib.paths.kinematics import ROUGHNESS, Differential
from omnimate.calib.paths.least_squares import PathCalibration, Quantity, quantities
from omnimate.calib.recordings import check_one_robot, check_one_truck
from omnimate.vehicle.linkage import follower
from omnimate.vehicle.parameters import JOINTS, Linkage, Truck
from omnimate.vehicle.se2 import inverse, rotation, transport

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from omnimate.calib.estimation.estimates import Estimate
    from omnimate.calib.linkage.drive import LinkageDrive
    from omnimate.calib.paths.kinematics import Steps
    from omnimate.vehicle.parameters import Truck, TruckName, VehicleParameters
    from omnimate.vehicle.recording import Recording
    from omnimate.vehicle.se2 import Array


# Sums and differences of the trucks' parameters: the linkage identifies the differences better.
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
JOINT = NoiseSource("joint reading", "rad", 2e-4)
LINK = NoiseSource("link reading", "m", 2e-4)
# (9, 9): coordinates above -> those of truck a, of truck b, and joint_a, joint_b, link
SEPARATE = np.eye(9)
SEPARATE[:6, :6] = np.kron(np.array([[1.0, 0.5], [1.0, -0.5]]), np.eye(3))
SEPARATE[6:8, 6:8] = [[1.0, 0.5], [1.0, -0.5]]


@dataclass(frozen=True, slots=True)
class LinkageProblem:
    """Drives of one robot with a linkage."""

    drives: tuple[LinkageDrive, ...]  # drives of the robot; each is a chain
    trucks: tuple[Truck, Truck]  # nominal a and b

    @property
    def source(self) -> str:
        """Files or folders that the data come from."""
        return ", ".join(dict.fromkeys(drive.source for drive in self.drives))

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Common values and differences of the trucks' parameters, then the biases of the linkage."""
        return COORDINATES

    @property
    def noises(self) -> tuple[NoiseSource, ...]:
        """The roughness of the floor, and the scatter of the linkage's encoders beyond their resolution."""
        return (ROUGHNESS, JOINT, LINK)

    def fixes(self) -> list[tuple[str, float]]:
        """Return the drive and the time [s] of each reading."""
        return [(drive.source, time) for drive in self.drives for time in drive.time.tolist()]

    def values(self, coordinates: Array) -> dict[str, float]:
        """Return the robot's parameters in SI units."""
        separate = SEPARATE @ coordinates
        result: dict[str, float] = {}
        for name, truck, of_truck in zip("ab", self.trucks, (separate[:3], separate[3:6]), strict=True):
            values = Differential(truck).values(of_truck)
            result |= {f"truck {name} {key}": value for key, value in values.items()}
        biases = zip(("joint_a bias", "joint_b bias", "link bias"), separate[6:], strict=True)
        return result | {name: float(value) for name, value in biases}

    def chains(self, coordinates: Array) -> Chains:
        """Return a chain for each drive, one after the other."""
        separate = SEPARATE @ coordinates
        return concatenate_chains([self._chain(drive, separate) for drive in self.drives], np.zeros(3))

    def _chain(self, drive: LinkageDrive, separate: Array) -> Chains:
        count = len(drive.time)
        models = [Differential(truck) for truck in self.trucks]
        moved_a, slope_a, process_a = _moved(drive, models[0].steps(drive.wheels[:, :2], separate[:3]))
        moved_b, slope_b, process_b = _moved(drive, models[1].steps(drive.wheels[:, 2:], separate[3:6]))
        measured, slopes = _relative(drive, separate[6:])
        carry = transport(measured)  # errors of a in the frame of b, with opposite sign
        sensitivity = np.zeros((count, 3, 9))
        sensitivity[:, :, :3], sensitivity[:, :, 3:6] = -carry @ slope_a, slope_b
        effect = np.zeros((count, 3, 9))
        effect[:, :, 6:] = rotation(measured[:, 2]) @ slopes
        return Chains(
            first=np.arange(count) == 0,
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
    """Return a truck's movements before each reading; see `join_steps`."""
    ends = drive.ends.astype(np.float64)
    return join_steps(np.concatenate((ends[:1], ends[:-1])), ends, *steps)


def _relative(drive: LinkageDrive, biases: Array) -> tuple[Array, Array]:
    """Return truck b seen from a `(M, 3)`, and its derivative by the biases `(M, 3, 3)`, 0 in closures."""
    joint_a, joint_b, length = (drive.linkage - biases).T
    read = follower(np.zeros(3), joint_a, joint_b, length)
    cos, sin, zeros, ones = np.cos(joint_a), np.sin(joint_a), np.zeros(len(length)), np.ones(len(length))
    by_a = np.stack([length * sin, length * cos, -ones], axis=-1)
    by_b = np.stack([zeros, zeros, ones], axis=-1)
    by_length = np.stack([-cos, sin, zeros], axis=-1)
    slopes = np.stack([by_a, by_b, by_length], axis=-1)
    closed = drive.closed
    pose = np.where(closed[:, np.newaxis], drive.relative, read)
    return pose, np.where(closed[:, np.newaxis, np.newaxis], 0.0, slopes)


def _stated(drive: LinkageDrive, slopes: Array) -> Array:
    """Return the covariances `(M, 3, 3)` by the resolution of the encoders, or the stated ones."""
    read = slopes @ np.diag(drive.resolution**2 / 12.0) @ slopes.transpose(0, 2, 1)
    closed = drive.closed[:, np.newaxis, np.newaxis]
    return np.where(closed, drive.covariance, read + 1e-14 * np.eye(3))


def _scatter(slopes: Array) -> Array:
    """Return the covariances `(2, M, 3, 3)` per unit variance of the joints' and the link's scatter."""
    kinds = [np.diag([1.0, 1.0, 0.0]), np.diag([0.0, 0.0, 1.0])]
    return np.stack([slopes @ kind @ slopes.transpose(0, 2, 1) for kind in kinds])


@dataclass(frozen=True, slots=True)
class LinkageCalibration:
    """The calibration of a robot by its linkage."""

    source: str  # files or folders that the data come from
    estimate: Estimate  # estimated coordinates, with those held because the linkage does not identify them
    trucks: dict[TruckName, Truck]  # corrected trucks a and b
    joint_bias: tuple[float, float]  # bias of joint_a and of joint_b, reading minus truth [rad]
    link_bias: float  # bias of the link, reading minus truth [m]
    quantities: tuple[Quantity, ...]  # all parameters with their uncertainties


def calibrate_linkage(
    recordings: Sequence[Recording],
    *,
    trucks: Mapping[TruckName, PathCalibration] | None = None,
    hold: Collection[str] = (),
) -> LinkageCalibration:
    """Return the calibration of a robot's linkage from drives with turns.

    Args:
        recordings: Recordings of one robot with a linkage; absolute poses of both trucks at the same time
            are used, where there are some.
        trucks: Calibrations of its trucks from absolute poses, used as known with their uncertainty.
        hold: Names of coordinates that stay nominal.

    Raises:
        CalibrationError: The robots differ, there is no linkage, a channel is frozen, or the drive is too
            short.
        UnobservableError: The drives identify no parameter.
    """
    check_one_robot(recordings)
    vehicle = recordings[0].vehicle
    for truck in vehicle.trucks:
        check_one_truck(recordings, truck)
    for recording in recordings:
        if recording.vehicle.linkage != vehicle.linkage:
            raise CalibrationError(
                recording.source,
                f"its linkage differs from that of {recordings[0].source}; expected one robot",
            )
    drives = tuple(map(linkage_drive, recordings))
    known = dict(trucks or {})
    nominal = {name: known[name].truck if name in known else vehicle.trucks[name] for name in vehicle.trucks}
    problem = LinkageProblem(drives, (nominal["a"], nominal["b"]))
    result = estimate(problem, hold, _information(known))
    separate = SEPARATE @ result.coordinates
    return LinkageCalibration(
        problem.source,
        result,
        {
            "a": Differential(nominal["a"]).truck_at(separate[:3]),
            "b": Differential(nominal["b"]).truck_at(separate[3:6]),
        },
        (float(separate[6]), float(separate[7])),
        float(separate[8]),
        quantities(problem.values, len(COORDINATES), result),
    )


def corrected_linkage(vehicle: VehicleParameters, calibration: LinkageCalibration) -> VehicleParameters:
    """Return a robot with calibrated trucks, joint zeros and link length.

    A zero is a whole number of counts, so a bias of up to half a count may remain.
    """
    return without_biases(vehicle, calibration.trucks, calibration.joint_bias, calibration.link_bias)


def without_biases(
    vehicle: VehicleParameters,
    trucks: Mapping[TruckName, Truck],
    joint_bias: tuple[float, float],
    link_bias: float,
) -> VehicleParameters:
    """Return a robot with other trucks, and zeros and length of its linkage without biases [rad], [m]."""
    assert vehicle.linkage is not None  # or nothing could have been learned of it
    biases = dict(zip(JOINTS, joint_bias, strict=True))
    encoders = tuple(
        replace(encoder, zero=encoder.zero + round(biases[encoder.channel] / encoder.scale))
        if encoder.channel in biases
        else encoder
        for encoder in vehicle.encoders
    )
    linkage = Linkage(vehicle.linkage.length - link_bias)
    return replace(corrected_vehicle(vehicle, trucks), linkage=linkage, encoders=encoders)


def _information(calibrations: Mapping[TruckName, PathCalibration]) -> Array:
    """Return the information `(9, 9)` of calibrations of the trucks on the coordinates."""
    information = np.zeros((9, 9))
    for name, calibration in calibrations.items():
        start = 0 if name == "a" else 3
        covariance = calibration.estimate.covariance[:3, :3]
        free = np.flatnonzero(np.diag(covariance) > 0.0)
        inside = np.ix_(free, free)
        part = np.zeros((3, 3))
        part[inside] = np.linalg.inv(covariance[inside])
        information[start : start + 3, start : start + 3] = part
    return SEPARATE.T @ information @ SEPARATE
