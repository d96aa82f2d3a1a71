"""The path designer: which drive identifies which parameters how well, before anybody drives it.

Every candidate gets the same way of the wheels, in the space given. Its Cramer-Rao bound follows from the
floor's roughness and the noise of the fixes alone. What it leaves of E_max,syst on a square, U (3.4), is the
mean over what a calibration with that bound would get wrong.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from calib.chain import square_returns
from calib.design_paths import (
    counted_spin,
    figure_eight,
    free_lap,
    open_straight,
    out_and_back,
    square,
)
from calib.errors import CalibrationError
from calib.kinematics import Differential
from calib.observability import Held, information_bound, unobservable
from calib.reference import ReferenceProblem

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from calib.design_paths import Way
    from vehicle.parameters import Truck
    from vehicle.se2 import Array

# [m/sqrt(m)] With it, one return position of a 4 x 4 m square scatters by 25 mm in x and in y, U V.
ROUGHNESS = 5.6e-4
POSITION = 2e-3  # [m] of the sonar calibrator, U V
SONAR_HEADING = math.radians(0.4)  # likewise
FINE_HEADING = math.radians(0.02)  # of motion capture or a theodolite, averaged at rest
_JUDGED = 4.0  # [m] side of the square on which a calibration is judged
_DRAWS = 20_000
_SHARES = np.linspace(0.05, 0.6, 12)  # of the way that spins may take


@dataclass(frozen=True, slots=True)
class Space:
    """What is there to drive in.

    Attributes:
        length: of the free rectangle [m].
        width: likewise [m].
        way: that the wheels may roll in all [m].
        heading: standard deviation of measured absolute headings [rad]; None where there are positions only.
        roughness: of the floor [m/sqrt(m)].

    Raises:
        CalibrationError: no such space.
    """

    length: float
    width: float
    way: float
    heading: float | None = None
    roughness: float = ROUGHNESS

    def __post_init__(self) -> None:
        for name in ("length", "width", "way", "roughness", "heading"):
            value = getattr(self, name)
            if value is not None and not (math.isfinite(value) and value > 0.0):
                raise CalibrationError("design", f"{name} {value}; expected a positive number")

    @property
    def sigma(self) -> Array:
        """Standard deviations `(3,)` of a fix; nan where it is not measured."""
        return np.array([POSITION, POSITION, np.nan if self.heading is None else self.heading])


@dataclass(frozen=True, slots=True)
class Design:
    """One candidate drive.

    Attributes:
        name: of the drive.
        laps: how many of it.
        way: that the wheels roll [m].
        sigma: (3,) bounds of wheelbase, E_s and E_d, relative; nan where held.
        held: what it does not identify.
        leaves: E_max,syst on a square of 4 m that is left on average [m]; nan where it cannot be told.
    """

    name: str
    laps: int
    way: float
    sigma: Array
    held: tuple[Held, ...]
    leaves: float

    @property
    def identifies(self) -> bool:
        """Whether it tells both the wheelbase and E_d, all that a square needs."""
        return bool(np.isfinite(self.sigma[[0, 2]]).all())


def compare_designs(truck: Truck, space: Space) -> tuple[Design, ...]:
    """Return the candidates for a truck in a space, best first; those that identify too little come last."""
    designs = [
        *(assess(name, truck, space, ways) for name, ways in _candidates(truck, space)),
        straights_and_spins(truck, space),
    ]
    return tuple(sorted(designs, key=lambda one: math.inf if math.isnan(one.leaves) else one.leaves))


def assess(name: str, truck: Truck, space: Space, ways: Sequence[Way]) -> Design:
    """Return what drives identify, by the bound, and what a calibration from them would leave.

    Raises:
        CalibrationError: the way is too short for any of them.
    """
    if not ways:
        raise CalibrationError("design", f"{space.way:g} m of way are too short for {name}")
    problem = ReferenceProblem(tuple(way.drive(space.sigma, name) for way in ways), Differential(truck))
    chains = problem.chains(np.zeros(3))
    variances = np.array([space.roughness**2, *(0.0 for _ in problem.noises[1:])])
    filtered, _ = chains.filtered(variances, np.ones(len(chains.first)))
    slope = filtered.innovation[:, :, 1:]
    information = np.tensordot(slope, filtered.precision @ slope, ((0, 1), (0, 1)))
    held = unobservable(problem.coordinates, information, np.ones(3, np.bool_))
    lost = {one.name for one in held}
    free = np.array([one.name not in lost for one in problem.coordinates])
    bound = information_bound(information, free)
    sigma = np.where(free, np.sqrt(np.diag(bound)), np.nan)
    leaves = _left(truck, bound) if free[0] and free[2] else math.nan
    return Design(name, len(ways), sum(way.rolled for way in ways), sigma, held, leaves)


def straights_and_spins(truck: Truck, space: Space) -> Design:
    """Return open straights plus counted spins, left and right alike, with the best share of either."""
    name = f"open straights of {space.length:g} m plus counted spins"
    found = []
    for share in _SHARES:
        straights = max(1, round((1.0 - share) * space.way / space.length))
        turn = math.pi * truck.wheelbase
        turns = max(1, round(0.5 * (space.way - straights * space.length) / turn))
        ways = [open_straight(truck, space.length) for _ in range(straights)]
        ways += [counted_spin(truck, turns), counted_spin(truck, -turns)]
        found.append(assess(name, truck, space, ways))
    return min(found, key=lambda one: math.inf if math.isnan(one.leaves) else one.leaves)


def _candidates(truck: Truck, space: Space) -> list[tuple[str, list[Way]]]:
    side = min(space.length, space.width)
    radius = min(0.25 * space.length, 0.5 * space.width)
    chance = np.random.default_rng(0)
    return [
        (f"UMBmark, squares of {side:g} m cw and ccw", _both(truck, side, space)),
        (f"squares of {side:g} m, one direction", _fill(space, lambda _: square(truck, side, 1))),
        (
            f"{space.length:g} m out, and back in reverse",
            _fill(space, lambda _: out_and_back(truck, space.length)),
        ),
        (f"figures of eight, radius {radius:g} m", _fill(space, lambda _: figure_eight(truck, radius))),
        (
            "free, past random points",
            _fill(space, lambda _: free_lap(truck, space.length, space.width, chance)),
        ),
    ]


def _both(truck: Truck, side: float, space: Space) -> list[Way]:
    """Return as many squares in either direction as the legs, U III-C, fit into the way."""
    pairs = max(1, round(space.way / (8.0 * side)))
    return [square(truck, side, sign) for sign in (-1, 1) for _ in range(pairs)]


def _fill(space: Space, make: Callable[[int], Way]) -> list[Way]:
    """Return drives until the way is used up, one at least."""
    ways = [make(0)]
    while sum(way.rolled for way in ways) + 0.5 * ways[-1].rolled < space.way:
        ways.append(make(len(ways)))
    return ways


def _left(truck: Truck, bound: Array) -> float:
    """Return the mean E_max,syst [m] on the square that errors of wheelbase and E_d with a bound make."""
    model, columns = Differential(truck), []
    for coordinate in (0, 2):
        step = np.zeros(3)
        step[coordinate] = 1e-6
        columns.append(square_returns(truck, model.truck_at(step), _JUDGED)[:, :2] / 1e-6)
    spread = np.linalg.cholesky(bound[np.ix_([0, 2], [0, 2])])
    errors = np.random.default_rng(0).standard_normal((_DRAWS, 2)) @ spread.T
    returns = np.einsum("nk,kij->nij", errors, np.array(columns))
    return float(np.linalg.norm(returns, axis=2).max(axis=1).mean())
