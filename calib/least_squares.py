"""Calibration from any drive with absolute poses, dense or at the stops.

It gives wheelbase and diameters, where the reference sits on the robot, and its clock; after Antonelli,
Chiaverini & Fusco (2005) and Censi et al. (2013).

The error of dead reckoning grows from fix to fix with the way (Chong & Kleeman, 1997), and successive
increments share the noise of the pose between them. Both are in the filter that whitens the residuals
(`calib.filtering`), which is the same as generalised least squares on the increments; a plain fit of whole
paths would count one early error in every later pose, and its stated uncertainty would mean nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from calib.drives import drives_of, thinned
from calib.estimation import estimate
from calib.kinematics import Differential, Kinematics
from calib.reference import OFFSETS, ReferenceProblem

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping, Sequence

    from calib.drives import Drive
    from calib.estimates import Estimate
    from vehicle.parameters import Truck, TruckName
    from vehicle.recording import Recording
    from vehicle.se2 import Array

SPACING = 2.0  # [s] between absolute poses that are used; see `calib.drives.thinned`
_STEP = 1e-5  # of a coordinate, for derivatives of values


@dataclass(frozen=True, slots=True)
class Quantity:
    """One physical parameter with its uncertainty, in SI units.

    Attributes:
        name: for tables.
        nominal: before.
        value: estimated.
        sigma: Cramer-Rao bound with the noise estimated.
        low: end of the 95 % interval.
        high: likewise.
    """

    name: str
    nominal: float
    value: float
    sigma: float
    low: float
    high: float


@dataclass(frozen=True, slots=True)
class PathCalibration:
    """What drives with absolute poses say about a robot.

    Attributes:
        source: where the data came from.
        estimate: of the coordinates, with noise, bound, held parameters and fixes that were down-weighted.
        kinematics: the corrected robot.
        quantities: its parameters, then those of the reference.
    """

    source: str
    estimate: Estimate
    kinematics: Kinematics
    quantities: tuple[Quantity, ...]

    @property
    def truck(self) -> Truck:
        """The corrected truck of a differential drive."""
        assert isinstance(self.kinematics, Differential)  # the caller calibrated one
        return self.kinematics.truck

    @property
    def lever(self) -> Array:
        """Where the reference sits on the robot, `(3,)` [m, m, rad]; zero where that was not estimated."""
        found = {one.name: one.value for one in self.quantities}
        return np.array([found.get(one.name, 0.0) for one in OFFSETS])


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
        recordings: of one robot.
        truck: which one.
        with_offset: estimate where the reference sits on the truck: x, y [m] and yaw [rad].
        with_time: estimate the reference's delay [s].
        hold: names of coordinates that stay nominal.
        spacing: of the poses that are used [s]; 0 takes all.

    Raises:
        CalibrationError: no poses, another clock, different robots, a frozen wheel, no convergence.
        UnobservableError: the drives tell nothing.
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
    chosen = tuple(thinned(drive, spacing) for drive in drives)
    problem = ReferenceProblem(chosen, kinematics, with_offset=with_offset, with_time=with_time)
    found = estimate(problem, hold)
    own = len(kinematics.coordinates)
    robot = quantities(kinematics.values, own, found)
    rest = quantities(
        lambda all_: {one.name: float(all_[own + place]) for place, one in enumerate(found.names[own:])},
        len(found.names),
        found,
    )
    return PathCalibration(
        problem.source, found, kinematics.corrected(found.coordinates[:own]), (*robot, *rest)
    )


def quantities(
    values: Callable[[Array], Mapping[str, float]], count: int, found: Estimate
) -> tuple[Quantity, ...]:
    """Return what functions of the first `count` coordinates are, with intervals to first order."""
    place, covariance = found.coordinates[:count], found.covariance[:count, :count]
    nominal, value = values(np.zeros(count)), values(place)
    steps = _STEP * np.eye(count)
    ahead = [values(place + step) for step in steps]
    behind = [values(place - step) for step in steps]
    width = found.half_width()
    result = []
    for name in value:
        slope = np.array([one[name] - other[name] for one, other in zip(ahead, behind, strict=True)])
        sigma = float(np.sqrt(slope @ covariance @ slope)) / (2.0 * _STEP)
        reach = width * sigma
        ends = value[name] - reach, value[name] + reach
        result.append(Quantity(name, nominal[name], value[name], sigma, *ends))
    return tuple(result)
