"""Calibration of the linkage: joint biases, link bias, and the trucks as far as the linkage tells them, C 5.

C 5.1 mentions a calibration of the wheel diameters from the corrections that IPEC makes on a smooth floor.
These corrections are what the linkage reads against what the wheels turned; here all of it is fitted at once,
in increments from reading to reading, weighed by the noise of both. What no reading of the linkage can tell
stays nominal and is named. Above all, with both diameter ratios wrong alike the robot drives a curve that its
joints show as a difference of their biases, C 5.2: no drive tells these two apart from inside.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from calib.apply import corrected_vehicle
from calib.errors import CalibrationError
from calib.estimation import estimate
from calib.kinematics import Differential
from calib.least_squares import PathCalibration, Quantity, quantities
from calib.linkage_drive import linkage_drive
from calib.linkage_problem import BIASES, COORDINATES, SEPARATE, LinkageProblem
from calib.recordings import check_one_robot
from vehicle.parameters import JOINTS, Linkage

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from calib.estimates import Estimate
    from vehicle.parameters import Truck, TruckName, VehicleParameters
    from vehicle.recording import Recording
    from vehicle.se2 import Array

WINDOW = 0.5  # [s] of driving between readings that are used


@dataclass(frozen=True, slots=True)
class LinkageCalibration:
    """What the linkage says of a robot.

    Attributes:
        source: where the data came from.
        estimate: of the coordinates, with what is held because the linkage does not tell it.
        trucks: corrected a and b.
        joint_bias: that joint_a and joint_b read too much [rad].
        link_bias: that the link reads too much [m].
        quantities: all parameters with their uncertainties.
    """

    source: str
    estimate: Estimate
    trucks: dict[TruckName, Truck]
    joint_bias: tuple[float, float]
    link_bias: float
    quantities: tuple[Quantity, ...]


def calibrate_linkage(
    recordings: Sequence[Recording],
    *,
    trucks: Mapping[TruckName, PathCalibration] | None = None,
    closures: bool = True,
    hold: Collection[str] = (),
    window: float = WINDOW,
) -> LinkageCalibration:
    """Return the calibration of a robot's linkage from drives with turns.

    Args:
        recordings: of one robot with a linkage.
        trucks: calibrations of its trucks from absolute poses, taken as known with their uncertainty.
        closures: use absolute poses of both trucks at the same time, where there are any.
        hold: names of coordinates that stay nominal.
        window: of driving between readings that are used [s].

    Raises:
        CalibrationError: different robots, no linkage, a frozen channel, too short a drive.
        UnobservableError: the drives tell nothing.
    """
    if not recordings:
        raise CalibrationError("linkage calibration", "no recording given")
    check_one_robot(recordings)
    vehicle = recordings[0].vehicle
    for recording in recordings:
        if recording.vehicle.trucks != vehicle.trucks or recording.vehicle.linkage != vehicle.linkage:
            raise CalibrationError(
                recording.source, f"its robot differs from that of {recordings[0].source}; expected one robot"
            )
    drives = tuple(linkage_drive(recording, window, closures=closures) for recording in recordings)
    found = dict(trucks or {})
    nominal = {name: found[name].truck if name in found else vehicle.trucks[name] for name in vehicle.trucks}
    problem = LinkageProblem(drives, (nominal["a"], nominal["b"]))
    result = estimate(problem, hold, _known(found))
    apart = SEPARATE @ result.coordinates
    return LinkageCalibration(
        problem.source,
        result,
        {
            "a": Differential(nominal["a"]).truck_at(apart[:3]),
            "b": Differential(nominal["b"]).truck_at(apart[3:6]),
        },
        (float(apart[6]), float(apart[7])),
        float(apart[8]),
        quantities(problem.values, len(COORDINATES), result),
    )


def calibrate_from_corrections(recordings: Sequence[Recording], window: float = WINDOW) -> LinkageCalibration:
    """Return the trucks that the linkage's readings ask for, its own biases taken as known, C 5.1.

    Raises:
        CalibrationError: as `calibrate_linkage`.
    """
    return calibrate_linkage(recordings, closures=False, hold=BIASES, window=window)


def corrected_linkage(vehicle: VehicleParameters, found: LinkageCalibration) -> VehicleParameters:
    """Return the same robot with calibrated trucks, its joints' zeros and its link's length shifted.

    A zero is a whole number of counts, so half a count of a bias may remain.
    """
    assert vehicle.linkage is not None  # or it could not have been calibrated
    linkage = Linkage(vehicle.linkage.length - found.link_bias)
    vehicle = corrected_vehicle(vehicle, found.trucks)
    biases = dict(zip(JOINTS, found.joint_bias, strict=True))
    encoders = tuple(
        replace(encoder, zero=encoder.zero + round(biases[encoder.channel] / encoder.scale))
        if encoder.channel in biases
        else encoder
        for encoder in vehicle.encoders
    )
    return replace(vehicle, linkage=linkage, encoders=encoders)


def _known(found: Mapping[TruckName, PathCalibration]) -> Array:
    """Return the information `(9, 9)` on the coordinates that calibrations of the trucks hold."""
    information = np.zeros((9, 9))
    for name, calibration in found.items():
        start = 0 if name == "a" else 3
        covariance = calibration.estimate.covariance[:3, :3]
        free = np.flatnonzero(np.diag(covariance) > 0.0)
        inside = np.ix_(free, free)
        part = np.zeros((3, 3))
        part[inside] = np.linalg.inv(covariance[inside])
        information[start : start + 3, start : start + 3] = part
    return SEPARATE.T @ information @ SEPARATE
