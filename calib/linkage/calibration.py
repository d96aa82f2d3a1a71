"""Calibration of the linkage, and of the trucks as far as the linkage identifies them, C 5.

C 5.1 mentions a calibration of the wheel diameters from the corrections that IPEC makes on a smooth floor.
These corrections are the difference between the readings of the linkage and the turns of the wheels; here all
parameters are fitted to them together, in increments from reading to reading, weighed by the noise of both.
Parameters that no reading of the linkage identifies stay nominal and are named. In particular, if both
diameter ratios are wrong by the same factor, the robot drives a curve that its joints show as a difference of
their biases, C 5.2: no drive without outside measurement separates these two.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from omnimate.calib.apply import corrected_vehicle
from omnimate.calib.errors import CalibrationError
from omnimate.calib.estimation.search import estimate
from omnimate.calib.linkage.drive import linkage_drive
from omnimate.calib.linkage.problem import COORDINATES, SEPARATE, LinkageProblem
from omnimate.calib.paths.kinematics import Differential
from omnimate.calib.paths.least_squares import PathCalibration, Quantity, quantities
from omnimate.calib.recordings import check_one_robot, check_one_truck
from omnimate.vehicle.parameters import JOINTS, Linkage, Truck

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from omnimate.calib.estimation.estimates import Estimate
    from omnimate.vehicle.parameters import TruckName, VehicleParameters
    from omnimate.vehicle.recording import Recording
    from omnimate.vehicle.se2 import Array


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
