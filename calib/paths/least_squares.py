"""Calibration from any drive with absolute poses, dense or at the stops.

It gives wheelbase and diameters, the pose of the reference on the robot, and the offset of its clock; after
Antonelli, Chiaverini & Fusco (2005) and Censi et al. (2013). Drives that do not fit the others of their set
are left out, and the cause is looked for: swapped wheels, or another clock.

The error of dead reckoning grows from fix to fix with the distance (Chong & Kleeman, 1997), and successive
increments share the noise of the pose between them. The filter that whitens the residuals contains both
(`omnimate.calib.estimation.filtering`); it is generalised least squares on the increments. A plain fit of
whole paths would count one early error in every later pose, and its stated uncertainty would be wrong.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from omnimate.calib.advice import Advice
from omnimate.calib.distributions import MAD_TO_SIGMA
from omnimate.calib.errors import CalibrationError
from omnimate.calib.estimation.residuals import Residuals, outlier_weights
from omnimate.calib.estimation.search import estimate
from omnimate.calib.paths.drives import drives_of, thin_fixes
from omnimate.calib.paths.kinematics import Differential, Kinematics
from omnimate.calib.paths.reference import OFFSETS, ReferenceProblem

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping, Sequence

    from numpy.typing import NDArray

    from omnimate.calib.estimation.estimates import Estimate
    from omnimate.calib.paths.drives import Drive
    from omnimate.vehicle.parameters import Truck, TruckName
    from omnimate.vehicle.recording import Recording
    from omnimate.vehicle.se2 import Array

SPACING = 2.0  # [s] time between absolute poses that are used; see `omnimate.calib.paths.drives.thin_fixes`
_DERIVATIVE_STEP = 1e-5  # step of a coordinate for numerical derivatives
_WEIGHING_ROUNDS = 6  # in which outliers lose their weight
_TENFOLD = float(np.log(10.0))  # squared residuals of a run over the median run's, for it to be left out
_HOPELESS = 100.0  # squared distance from which on no drive fits, and a cause is looked for
_BETTER = 10.0  # times smaller must a squared distance be with an error corrected, for it to be the cause
_SHIFTS = np.delete(np.arange(-20, 21), 20) / 10.0  # [s] errors of the clock that are tried
_OUTLIER_SIGMAS = 3.5  # [standard deviations] beyond it, a number is an outlier: Iglewicz & Hoaglin (1993)
_MIN_RUNS = 3  # runs from which on one can differ from the others
_CHI2_MEDIAN = 0.79  # median of chi^2 per degree of freedom, for three degrees


@dataclass(frozen=True, slots=True)
class Quantity:
    """One physical parameter with its uncertainty, in SI units."""

    name: str  # for tables
    nominal: float  # value before the calibration
    value: float  # estimated value
    # Cramer-Rao bound of the standard deviation, with the estimated noise; given the nominal values of the
    # coordinates that are held, and nan, as the interval, where they all are
    sigma: float
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
        with_time: Whether it is estimated how far the reference's clock is behind [s].
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
        variance = float(slope @ covariance @ slope)
        sigma = math.sqrt(variance) / (2.0 * _DERIVATIVE_STEP) if variance > 0.0 else math.nan
        reach = width * sigma
        ends = value[name] - reach, value[name] + reach
        listed.append(Quantity(name, nominal[name], value[name], sigma, *ends))
    return tuple(listed)


def squared_distances(problem: ReferenceProblem, coordinates: Array) -> Array:
    """Return the median squared distance `(N,)` of each drive's fixes from the prediction by all others.

    It is per degree of freedom, with the noise of a good measurement: about 1 of a drive that fits.
    """
    chains = problem.chains(coordinates)
    variances = np.array([noise.guess**2 for noise in problem.noises])
    none = np.zeros(len(coordinates))
    known = np.isfinite(chains.measured).sum(axis=1)
    weights = np.ones(len(known))
    for _ in range(_WEIGHING_ROUNDS):
        ahead, behind = chains.filtered(variances, weights)
        now = Residuals(chains, ahead.heading, behind, none, np.zeros((len(none), len(none))))
        square = now.distances(variances, weights)
        weights = np.sqrt(weights * outlier_weights(square, known))
    parts = np.split(square / (_CHI2_MEDIAN * known), np.flatnonzero(chains.first)[1:])
    return np.array([np.median(part) for part in parts])


def without_misfits(
    problem: ReferenceProblem, coordinates: Array
) -> tuple[ReferenceProblem, tuple[Advice, ...]]:
    """Return a problem without the drives that fit the coordinates much worse than the others, and which.

    Raises:
        CalibrationError: No drive fits, and there is a cause: swapped wheels, or a wrong clock.
    """
    squares = np.maximum(squared_distances(problem, coordinates), 1.0)
    outlying = _outlying(np.log(squares))
    if np.median(squares) > _HOPELESS:
        cause = _cause(problem, coordinates)
        if cause is not None and not (problem.with_time and "clock" in cause):
            raise CalibrationError(problem.source, f"poses and wheels do not fit each other: {cause}")
    advice = []
    for number in np.flatnonzero(outlying):
        alone = replace(problem, drives=(problem.drives[number],))
        why = _cause(alone, coordinates) or "is it of this robot, on this floor, with this clock?"
        times = math.sqrt(squares[number] / np.median(squares))
        what = (
            f"{alone.source} is left out: its poses are {times:.0f} times as far off as those of the others"
        )
        advice.append(Advice("warning", what, why))
    kept = tuple(drive for drive, out in zip(problem.drives, outlying, strict=True) if not out)
    return replace(problem, drives=kept), tuple(advice)


def _outlying(values: Array) -> NDArray[np.bool_]:
    """Return which of N numbers `(N,)` lie above the median by 3.5 robust standard deviations and `_TENFOLD`.

    The standard deviation is that of the median absolute deviation, which fewer than half of the runs cannot
    change; of few runs it may be small by chance, so that a distance is required as well.
    """
    if len(values) < _MIN_RUNS:
        return np.zeros(len(values), bool)
    away = values - np.median(values)
    sigma = MAD_TO_SIGMA * float(np.median(np.abs(away)))
    return np.asarray(away > max(_OUTLIER_SIGMAS * sigma, _TENFOLD), bool)


def _cause(problem: ReferenceProblem, coordinates: Array) -> str | None:
    """Return the single error of all drives whose correction makes them fit, in words; None without one."""
    swapped = [replace(drive, readings=drive.readings[:, ::-1]) for drive in problem.drives]
    causes = {"the left and the right wheel are swapped": swapped}
    for shift in _SHIFTS:
        words = f"the clock of the poses is {abs(shift):.1f} s {'ahead' if shift > 0.0 else 'behind'}"
        words += "; shift poses.csv, or estimate the delay (--time-offset)"
        causes[words] = [replace(drive, fix_time=drive.fix_time - shift) for drive in problem.drives]
    squares = {
        words: float(np.median(squared_distances(replace(problem, drives=tuple(drives)), coordinates)))
        for words, drives in causes.items()
    }
    best = min(squares, key=squares.__getitem__)
    now = float(np.median(squared_distances(problem, coordinates)))
    return best if now > _BETTER * max(squares[best], 1.0) else None
