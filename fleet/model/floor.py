"""The floor of a hall: its roughness and its bad places, each beside the other."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import minimize_scalar

from omnimate.fleet.joints import NO_JOINTS, Joints
from omnimate.fleet.model.days import Day, day_of
from omnimate.fleet.model.edges import errors_of
from omnimate.fleet.model.effects import floors_of
from omnimate.fleet.model.evidence import AllCrossings, Evidence, evidence_of
from omnimate.fleet.model.places import find_places
from omnimate.fleet.model.scores import grid_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.fleet.crossings import Crossings
    from omnimate.fleet.morning import BadPlace
    from omnimate.fleet.segments import Segments
    from omnimate.vehicle.se2 import Array

ROUNDS = 4
SETTLED = 0.05  # part by which roughness changes no more
SAMPLE = 1000  # recordings from which roughness and strong places are estimated in turn
ROUGHNESS_SAMPLE = 200  # recordings from which one estimate of the roughness is made
SMOOTHEST, ROUGHEST = 5e-5, 5e-3  # [m/sqrt(m)] between a steel plate and cobbles


@dataclass(frozen=True, slots=True)
class Driven:
    """What one recording gives.

    Attributes:
        robot: Name of the robot.
        kind: Type of the robot.
        day: Date, YYYY-MM-DD.
        segments: Its ways, two or more.
        crossings: What they go over.
        joints: Of its linkage.
        floor: Name of the floor; "" for the only one.
    """

    robot: str
    kind: str
    day: str
    segments: Segments
    crossings: Crossings
    joints: Joints = NO_JOINTS
    floor: str = ""

    def evidence(self, roughness: float) -> Evidence:
        """Return what it says on a floor of a roughness [m/sqrt(m)]."""
        return evidence_of(self.robot, self.kind, self.day, self.segments, self.crossings, roughness)


@dataclass(frozen=True, slots=True)
class Floor:
    """What recordings say of the floor.

    Attributes:
        places: Bad places, the clearest first.
        roughness: Of the floor beside these [m/sqrt(m)].
    """

    places: tuple[BadPlace, ...]
    roughness: float

    def days(self, driven: Sequence[Driven]) -> list[Day]:
        """Return what recordings say of their robots beside this floor."""
        crossings = AllCrossings([single.evidence(self.roughness) for single in driven])
        crossings.doubt(errors_of(self.places, crossings))
        floors = floors_of(self.places, crossings)
        return [
            day_of(single, floor, recording.joints)
            for single, floor, recording in zip(crossings.evidence, floors, driven, strict=True)
        ]


def floor_under(driven: Sequence[Driven], known: Sequence[BadPlace] = ()) -> Floor:
    """Return the floor under recordings of a fleet.

    Bad places that are not known yet look like a rough floor, on which they stand out less: both are
    estimated in turn until they settle. Strong places and roughness need not all recordings for it, which
    then show the weak ones.

    Args:
        driven: The recordings.
        known: Places to begin with.
    """
    some = driven[:: -(-len(driven) // SAMPLE)]
    places = tuple(known)
    roughness = _roughness(some, places, roughness_of([single.segments for single in some]))
    for _ in range(ROUNDS):
        places = _places(some, roughness, places)
        before, roughness = roughness, _roughness(some, places, roughness)
        if abs(roughness - before) < SETTLED * before:
            break
    if len(some) == len(driven):
        return Floor(places, roughness)
    places = _places(driven, roughness, places)
    return Floor(places, _roughness(driven, places, roughness))


def _places(driven: Sequence[Driven], roughness: float, known: Sequence[BadPlace]) -> tuple[BadPlace, ...]:
    evidence = [single.evidence(roughness) for single in driven]
    return find_places(evidence, grid_of(evidence), known)


def _roughness(driven: Sequence[Driven], places: Sequence[BadPlace], before: float) -> float:
    """Return the roughness beside places; weights of a roughness before do not matter for them."""
    if not places:
        return before
    floors = floors_of(places, AllCrossings([single.evidence(before) for single in driven]))
    return roughness_of([single.segments for single in driven], floors)


def roughness_of(segments: Sequence[Segments], floors: Sequence[Array] | None = None) -> float:
    """Return the median of what single recordings say [m/sqrt(m)]; sick robots move it little.

    Of squares alone `calib.umbmark.floor` knows no more than how their ends scatter, U section V.

    Args:
        segments: Of recordings, each with two ways or more; evenly spread ones of them are used.
        floors: What known places make of the residuals of each, `(3 S,)`; nothing by default.
    """
    chosen = range(0, len(segments), max(1, len(segments) // ROUGHNESS_SAMPLE))
    left = [
        segments[number].residual.reshape(-1) - (0.0 if floors is None else floors[number])
        for number in chosen
    ]
    return float(
        np.median([_likeliest(segments[number], rest) for number, rest in zip(chosen, left, strict=True)])
    )


def _likeliest(segments: Segments, residual: Array) -> float:
    """Return the likeliest roughness of one recording, by restricted likelihood beside its robot."""
    jacobian = segments.jacobian.reshape(-1, 3)

    def surprise(log_roughness: float) -> float:
        factor = np.linalg.cholesky(segments.covariance(math.exp(log_roughness)))
        white = np.linalg.solve(factor, np.column_stack([residual, jacobian]))
        basis, triangle = np.linalg.qr(white[:, 1:])
        left = white[:, 0] - basis @ (basis.T @ white[:, 0])
        weights = np.log(np.diag(factor)).sum() + np.log(np.abs(np.diag(triangle))).sum()
        return float(weights + 0.5 * left @ left)

    bounds = math.log(SMOOTHEST), math.log(ROUGHEST)
    return math.exp(minimize_scalar(surprise, bounds=bounds, method="bounded", options={"xatol": 0.01}).x)
