"""Design of calibration drives: the Cramer-Rao bound of candidate drives before they are driven.

Every candidate gets the same travel of the wheels, in the space given. Its Cramer-Rao bound follows from the
roughness of the floor and the noise of the fixes alone. The E_max,syst, U (3.4), that a calibration with this
bound would leave on a square is its mean over random errors with the covariance of the bound.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from omnimate.calib.errors import CalibrationError
from omnimate.calib.estimation.observability import Held, information_bound, unobservable
from omnimate.calib.paths.drives import Drive
from omnimate.calib.paths.kinematics import Differential
from omnimate.calib.paths.reference import ReferenceProblem
from omnimate.calib.umbmark.square import factor_ends
from omnimate.vehicle.floor import CONCRETE_ROUGHNESS

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from omnimate.vehicle.parameters import Truck
    from omnimate.vehicle.se2 import Array


SONAR_POSITION_SIGMA = 2e-3  # [m] standard deviation of a position by the sonar calibrator, U V
SONAR_HEADING_SIGMA = math.radians(0.4)  # [rad] standard deviation of a heading by the sonar calibrator, U V
MOTION_CAPTURE_HEADING_SIGMA = math.radians(0.02)  # [rad] standard deviation by motion capture at rest
_TEST_SIDE = 4.0  # [m] side of the square for the residual error, U III-C
_DRAWS = 20_000
_SPIN_SHARES = np.linspace(0.05, 0.6, 12)  # trial shares of the travel for spins
_TRAVEL_STEP = 0.1  # [m] of wheel travel in one step
SPEED = 0.2  # [m/s] of the wheels, U III-C


@dataclass(slots=True)
class PlannedDrive:
    """A builder of drives, as travel of the wheels."""

    truck: Truck  # the truck that drives it
    travel: list[Array] = field(default_factory=list)  # of both wheels in each step [m], `(2,)`
    fixes: list[int] = field(default_factory=list)  # steps after which an absolute pose is measured

    def straight(self, length: float) -> PlannedDrive:
        """Add a straight of a length [m]; a negative length is driven backwards."""
        return self._go(length, length)

    def spin(self, angle: float) -> PlannedDrive:
        """Add a turn on the spot by an angle [rad], left positive."""
        rim = 0.5 * self.truck.wheelbase * angle
        return self._go(-rim, rim)

    def arc(self, radius: float, angle: float) -> PlannedDrive:
        """Add an arc of a radius [m] driven forwards, by an angle [rad], left positive."""
        length, rim = radius * abs(angle), 0.5 * self.truck.wheelbase * angle
        return self._go(length - rim, length + rim)

    def fix(self) -> PlannedDrive:
        """Add a stop at which the pose is measured."""
        self.fixes.append(len(self.travel))
        return self

    def _go(self, left: float, right: float) -> PlannedDrive:
        count = max(1, math.ceil(max(abs(left), abs(right)) / _TRAVEL_STEP))
        self.travel += [np.array([left, right]) / count] * count
        return self

    @property
    def rolled(self) -> float:
        """Distance that the wheels roll [m], the mean of both."""
        return float(np.abs(np.array(self.travel)).mean(axis=1).sum())

    def measured(self, sigma: Array, source: str) -> Drive:
        """Return the measured drive; its fixes have standard deviations `(3,)`, nan where not measured."""
        readings = np.vstack([np.zeros((1, 2)), np.cumsum(self.travel, axis=0) / self.truck.radii])
        time = np.arange(len(readings), dtype=np.float64) * (_TRAVEL_STEP / SPEED)
        count = len(self.fixes)
        pose = np.tile(np.where(np.isfinite(sigma), 0.0, np.nan), (count, 1))
        return Drive(time, readings, time[np.array(self.fixes)], pose, np.tile(sigma, (count, 1)), source)


def square(truck: Truck, side: float, sign: int) -> PlannedDrive:
    """Return the square of U III-C in one direction, +1 ccw or -1 cw, with fixes before and after."""
    drive = PlannedDrive(truck).fix()
    for _ in range(4):
        drive.straight(side).spin(sign * 0.5 * math.pi)
    return drive.fix()


def out_and_back(truck: Truck, length: float) -> PlannedDrive:
    """Return a straight out and back in reverse, C 6.1, with fixes before and after."""
    return PlannedDrive(truck).fix().straight(length).straight(-length).fix()


def open_straight(truck: Truck, length: float) -> PlannedDrive:
    """Return a straight with fixes at both ends."""
    return PlannedDrive(truck).fix().straight(length).fix()


def counted_spin(truck: Truck, turns: int) -> PlannedDrive:
    """Return whole turns on the spot, left positive, with fixes before and after."""
    return PlannedDrive(truck).fix().spin(2.0 * math.pi * turns).fix()


def figure_eight(truck: Truck, radius: float) -> PlannedDrive:
    """Return a circle to the left and one to the right, with fixes before and after."""
    return PlannedDrive(truck).fix().arc(radius, 2.0 * math.pi).arc(radius, -2.0 * math.pi).fix()


def free_lap(truck: Truck, length: float, width: float, chance: np.random.Generator) -> PlannedDrive:
    """Return a drive past six random points of a rectangle and home again, with fixes before and after."""
    points = [*chance.uniform([0.0, -0.5 * width], [length, 0.5 * width], (6, 2)), np.zeros(2)]
    drive, place, heading = PlannedDrive(truck).fix(), np.zeros(2), 0.0
    for point in points:
        east, north = point - place
        wanted = math.atan2(north, east)
        turn = math.remainder(wanted - heading, 2.0 * math.pi)
        drive.spin(turn).straight(math.hypot(east, north))
        place, heading = point, heading + turn
    return drive.spin(math.remainder(-heading, 2.0 * math.pi)).fix()


@dataclass(frozen=True, slots=True)
class Space:
    """The space and the means that a calibration drive may use.

    Raises:
        CalibrationError: A size is not a positive number.
    """

    length: float  # length of the free rectangle [m]
    width: float  # width of the free rectangle [m]
    travel: float  # distance that the wheels may roll in all [m]
    heading: float | None = None  # standard deviation of absolute headings [rad]; None: not measured
    roughness: float = CONCRETE_ROUGHNESS  # roughness of the floor [m/sqrt(m)]

    def __post_init__(self) -> None:
        for name in ("length", "width", "travel", "roughness", "heading"):
            value = getattr(self, name)
            if value is not None and not (math.isfinite(value) and value > 0.0):
                raise CalibrationError("design", f"{name} {value}; expected a positive number")

    @property
    def sigma(self) -> Array:
        """Standard deviations of a fix in x, y [m] and theta [rad], shape `(3,)`; nan where not measured."""
        return np.array(
            [SONAR_POSITION_SIGMA, SONAR_POSITION_SIGMA, np.nan if self.heading is None else self.heading]
        )


@dataclass(frozen=True, slots=True)
class Design:
    """One candidate drive."""

    name: str
    laps: int  # number of times that it is driven
    travel: float  # distance that the wheels roll [m]
    sigma: Array  # Cramer-Rao bounds of wheelbase, E_s and E_d, relative, `(3,)`; nan where held
    held: tuple[Held, ...]  # coordinates that the drive does not identify, with the reasons
    residual_error: float  # mean E_max,syst left on a square of 4 m [m]; nan where E_b or E_d is held


def compare_designs(truck: Truck, space: Space) -> tuple[Design, ...]:
    """Return the candidates for a truck in a space, best first; those that identify too little are last."""
    designs = [
        *(assess(name, truck, space, drives) for name, drives in _candidates(truck, space)),
        straights_and_spins(truck, space),
    ]
    return tuple(sorted(designs, key=_rank))


def assess(name: str, truck: Truck, space: Space, drives: Sequence[PlannedDrive]) -> Design:
    """Return what drives identify, by the bound, and the error that a calibration from them would leave.

    Raises:
        CalibrationError: The allowed travel is too short for any of them.
    """
    if not drives:
        raise CalibrationError("design", f"{space.travel:g} m of travel are too short for {name}")
    problem = ReferenceProblem(
        tuple(drive.measured(space.sigma, name) for drive in drives), Differential(truck)
    )
    chains = problem.chains(np.zeros(3))
    variances = np.array([space.roughness**2, *(0.0 for _ in problem.noises[1:])])
    filtered, _ = chains.filtered(variances, np.ones(len(chains.first)))
    slope = filtered.innovation[:, :, 1:]
    information = np.tensordot(slope, filtered.precision @ slope, ((0, 1), (0, 1)))
    held, free = unobservable(problem.coordinates, information, np.ones(3, np.bool_))
    bound = information_bound(information, free)
    sigma = np.where(free, np.sqrt(np.diag(bound)), np.nan)
    residual_error = _residual_error(truck, bound) if free[0] and free[2] else math.nan
    return Design(name, len(drives), sum(drive.rolled for drive in drives), sigma, held, residual_error)


def _rank(design: Design) -> float:
    """Return the key that sorts the best design first and those without a residual error last."""
    return math.inf if math.isnan(design.residual_error) else design.residual_error


def straights_and_spins(truck: Truck, space: Space) -> Design:
    """Return open straights plus counted spins, as many left as right, in the best proportion."""
    name = f"open straights of {space.length:g} m plus counted spins"
    designs = []
    for share in _SPIN_SHARES:
        straights = max(1, round((1.0 - share) * space.travel / space.length))
        turn = math.pi * truck.wheelbase
        turns = max(1, round(0.5 * (space.travel - straights * space.length) / turn))
        drives = [open_straight(truck, space.length) for _ in range(straights)]
        drives += [counted_spin(truck, turns), counted_spin(truck, -turns)]
        designs.append(assess(name, truck, space, drives))
    return min(designs, key=_rank)


def _candidates(truck: Truck, space: Space) -> list[tuple[str, list[PlannedDrive]]]:
    side = min(space.length, space.width)
    radius = min(0.25 * space.length, 0.5 * space.width)
    chance = np.random.default_rng(0)
    return [
        (f"UMBmark, squares of {side:g} m cw and ccw", _squares(truck, side, space)),
        (f"squares of {side:g} m, one direction", _repeat(space, lambda _: square(truck, side, 1))),
        (
            f"{space.length:g} m out, and back in reverse",
            _repeat(space, lambda _: out_and_back(truck, space.length)),
        ),
        (f"figures of eight, radius {radius:g} m", _repeat(space, lambda _: figure_eight(truck, radius))),
        (
            "free, past random points",
            _repeat(space, lambda _: free_lap(truck, space.length, space.width, chance)),
        ),
    ]


def _squares(truck: Truck, side: float, space: Space) -> list[PlannedDrive]:
    """Return as many squares in either direction as their legs, U III-C, fit into the allowed travel."""
    pairs = max(1, round(space.travel / (8.0 * side)))
    return [square(truck, side, sign) for sign in (-1, 1) for _ in range(pairs)]


def _repeat(space: Space, make: Callable[[int], PlannedDrive]) -> list[PlannedDrive]:
    """Return drives until the allowed travel is used up, at least one."""
    drives = [make(0)]
    while sum(drive.rolled for drive in drives) + 0.5 * drives[-1].rolled < space.travel:
        drives.append(make(len(drives)))
    return drives


def _residual_error(truck: Truck, bound: Array) -> float:
    """Return the mean E_max,syst [m] on the square for errors of wheelbase and E_d with this covariance."""
    _, slopes = factor_ends(truck, _TEST_SIDE, np.zeros(2))
    spread = np.linalg.cholesky(bound[np.ix_([0, 2], [0, 2])])
    errors = np.random.default_rng(0).standard_normal((_DRAWS, 2)) @ spread.T
    returns = np.einsum("nk,ijk->nij", errors, slopes[:, :2])
    return float(np.linalg.norm(returns, axis=2).max(axis=1).mean())
