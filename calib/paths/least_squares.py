"""Calibration from any drive with absolute poses, dense or at the stops.

It gives wheelbase and diameters, the pose of the reference on the robot, and the offset of its clock; after
Antonelli, Chiaverini & Fusco (2005) and Censi et al. (2013).

The error of dead reckoning grows from fix to fix with the distance (Chong & Kleeman, 1997), and successive
increments share the noise of the pose between them. The filter that whitens the residuals contains both
(`omnimate.calib.estimation.filtering`); it is generalised least squares on the increments. A plain fit of
whole paths would count one early error in every later pose, and its stated uncertainty would be wrong.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.calib.estimation.search import estimate
from omnimate.calib.paths.drives import drives_of, thin_fixes
from omnimate.calib.paths.kinematics import Differential, Kinematics
from omnimate.calib.paths.misfits import without_misfits
from omnimate.calib.paths.reference import OFFSETS, ReferenceProblem

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping, Sequence

    from omnimate.calib.advice import Advice
    from omnimate.calib.estimation.estimates import Estimate
    from omnimate.calib.paths.drives import Drive
    from omnimate.vehicle.parameters import Truck, TruckName
    from omnimate.vehicle.recording import Recording
    from omnimate.vehicle.se2 import Array

SPACING = 2.0  # [s] time between absolute poses that are used; see `omnimate.calib.paths.drives.thin_fixes`
_DERIVATIVE_STEP = 1e-5  # step of a coordinate for numerical derivatives


@dataclass(frozen=True, slots=True)
class Quantity:
    """One physical parameter with its uncertainty, in SI units."""

    name: str  # for tables
    nominal: float  # value before the calibration
    value: float  # estimated value
    sigma: float  # Cramer-Rao bound of the standard deviation, with the estimated noise
    low: float  # lower end of the 95 % interval
    high: float  # upper end of the 95 % interval


@dataclass(frozen=True, slots=True)
class PathCalibration:
    """The calibration of a robot from drives with absolute poses.

    Attributes:
        source: Files or folders that the data come from.
        estimate: Estimated coordinates with noise, bound, held parameters and down-weighted fixes.
        kinematics: Model of the corrected robot.
        quantities: Parameters of the robot, then those of the reference.
        left_out: Drives that do not fit the others and were left out, and the cause as far as it is known.
    """

    source: str
    estimate: Estimate
    kinematics: Kinematics
    quantities: tuple[Quantity, ...]
    left_out: tuple[Advice, ...] = ()

    @property
    def truck(self) -> Truck:
        """The corrected truck of a differential drive."""
        assert isinstance(self.kinematics, Differential)  # the caller calibrated one
        return self.kinematics.truck

    @property
    def lever(self) -> Array:
        """Pose of the reference on the robot [m, m, rad], shape `(3,)`; zero where it was not estimated."""
        values = {quantity.name: quantity.value for quantity in self.quantities}
        return np.array([values.get(offset.name, 0.0) for offset in OFFSETS])


def calibrate_truck(
    recordings: Sequence[Recording],
    truck: TruckName = "a",
    *,
    with_offset: bool = False,
    with_time: bool = False,
    hold: Collection[str] = (),
    spacing: float = SPACING,
) -> PathCalibration:
    """Return the calibration of one truck from recordings of any drive.

    Args:
        recordings: Recordings of one robot.
        truck: Name of the truck, a or b.
        with_offset: Whether the reference's pose on the truck is estimated: x, y [m] and yaw [rad].
        with_time: Whether the reference's delay [s] is estimated.
        hold: Names of coordinates that stay nominal.
        spacing: Time between the poses that are used [s]; 0 takes all.

    Raises:
        CalibrationError: There are no poses, they have another clock, the recordings are of different robots,
            a wheel is frozen, or the fit does not converge.
        UnobservableError: The drives identify no parameter.
    """
    drives = drives_of(recordings, truck)
    kinematics = Differential(recordings[0].vehicle.trucks[truck])
    return calibrate_path(
        drives, kinematics, with_offset=with_offset, with_time=with_time, hold=hold, spacing=spacing
    )


def calibrate_path(
    drives: Sequence[Drive],
    kinematics: Kinematics,
    *,
    with_offset: bool = False,
    with_time: bool = False,
    hold: Collection[str] = (),
    spacing: float = SPACING,
) -> PathCalibration:
    """Return the calibration of a robot of any kinematics; the arguments are those of `calibrate_truck`."""
    chosen = tuple(thin_fixes(drive, spacing) for drive in drives)
    problem = ReferenceProblem(chosen, kinematics, with_offset=with_offset, with_time=with_time)
    problem, left_out = without_misfits(problem, np.zeros(len(problem.coordinates)))
    while True:
        result = estimate(problem, hold)
        fewer, misfits = without_misfits(problem, result.coordinates)
        if not misfits:
            break
        problem, left_out = fewer, (*left_out, *misfits)
    count = len(kinematics.coordinates)
    names = [offset.name for offset in result.parameters[count:]]
    robot = quantities(kinematics.values, count, result)
    reference = quantities(
        lambda values: {name: float(value) for name, value in zip(names, values[count:], strict=True)},
        len(result.parameters),
        result,
    )
    corrected = kinematics.corrected(result.coordinates[:count])
    return PathCalibration(problem.source, result, corrected, (*robot, *reference), left_out)


def quantities(
    values: Callable[[Array], Mapping[str, float]], count: int, result: Estimate
) -> tuple[Quantity, ...]:
    """Return functions of the first `count` coordinates as quantities, with intervals to first order."""
    place, covariance = result.coordinates[:count], result.covariance[:count, :count]
    nominal, value = values(np.zeros(count)), values(place)
    steps = _DERIVATIVE_STEP * np.eye(count)
    ahead = [values(place + step) for step in steps]
    behind = [values(place - step) for step in steps]
    width = result.half_width
    listed = []
    for name in value:
        slope = np.array([high[name] - low[name] for high, low in zip(ahead, behind, strict=True)])
        sigma = float(np.sqrt(slope @ covariance @ slope)) / (2.0 * _DERIVATIVE_STEP)
        reach = width * sigma
        ends = value[name] - reach, value[name] + reach
        listed.append(Quantity(name, nominal[name], value[name], sigma, *ends))
    return tuple(listed)
