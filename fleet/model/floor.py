"""The floor of a hall: its roughness and its bad places, estimated in turn."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import minimize_scalar

from omnimate.fleet.model.edges import crossing_errors
from omnimate.fleet.model.evidence import FleetEvidence, weigh_segments
from omnimate.fleet.model.histories import RobotInformation
from omnimate.fleet.model.places import find_places

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.fleet.features import RecordingFeatures
    from omnimate.fleet.report import BadPlace
    from omnimate.fleet.segments import Segments
    from omnimate.vehicle.se2 import Array

MAX_ROUNDS = 4  # of estimating places and roughness in turn
ROUGHNESS_TOLERANCE = 0.05  # relative change of the roughness at which it has converged
MAX_SAMPLE = 1000  # recordings from which roughness and strong places are estimated in turn
ROUGHNESS_SAMPLE = 200  # recordings from which one estimate of the roughness is made
MIN_ROUGHNESS, MAX_ROUGHNESS = 5e-5, 5e-3  # [m/sqrt(m)] between a steel plate and cobbles


@dataclass(frozen=True, slots=True)
class Floor:
    """A floor.

    Attributes:
        places: Bad places, the clearest first.
        roughness: Of the floor outside these [m/sqrt(m)].
    """

    places: tuple[BadPlace, ...]
    roughness: float

    def robot_information(self, features: Sequence[RecordingFeatures]) -> list[RobotInformation]:
        """Return the information of recordings on their robots, without the effect of this floor's places."""
        fleet = _weigh(features, self.roughness)
        fleet.set_errors(crossing_errors(self.places, fleet))
        effects = fleet.sum_effects(self.places)
        return [
            RobotInformation(
                some.robot, some.kind, some.day, *evidence.robot_information(effect), some.joints
            )
            for some, evidence, effect in zip(features, fleet.recordings, effects, strict=True)
        ]


def estimate_floor(features: Sequence[RecordingFeatures], known: Sequence[BadPlace] = ()) -> Floor:
    """Return the floor under recordings of a fleet.

    Bad places that are not known yet look like a rough floor, on which they stand out less: both are
    estimated in turn until they converge. Strong places and roughness need not all recordings for it, which
    then show the weak ones.

    Args:
        features: Of the recordings.
        known: Places to begin with.
    """
    sample = features[:: -(-len(features) // MAX_SAMPLE)]
    places = tuple(known)
    roughness = estimate_roughness([recording.segments for recording in sample])
    if places:
        effects = _weigh(sample, roughness).sum_effects(places)
        roughness = estimate_roughness([recording.segments for recording in sample], effects)
    floor = Floor(places, roughness)
    for _ in range(MAX_ROUNDS):
        before, floor = floor, _update_floor(floor, sample)
        if abs(floor.roughness - before.roughness) < ROUGHNESS_TOLERANCE * before.roughness:
            break
    return floor if len(sample) == len(features) else _update_floor(floor, features)


def _update_floor(floor: Floor, features: Sequence[RecordingFeatures]) -> Floor:
    """Return the places on a floor of known roughness, and the roughness outside these."""
    fleet = _weigh(features, floor.roughness)
    places = find_places(fleet, floor.places)
    if not places:
        return Floor(places, floor.roughness)
    segments = [recording.segments for recording in features]
    return Floor(places, estimate_roughness(segments, fleet.sum_effects(places)))


def _weigh(features: Sequence[RecordingFeatures], roughness: float) -> FleetEvidence:
    return FleetEvidence(
        [weigh_segments(recording.segments, recording.crossings, roughness) for recording in features]
    )


def estimate_roughness(segments: Sequence[Segments], effects: Sequence[Array] | None = None) -> float:
    """Return the median of the recordings' likeliest roughness [m/sqrt(m)]; faulty robots move it little.

    Of squares alone `calib.umbmark.floor` knows no more than how their ends scatter, U section V.

    Args:
        segments: Of recordings, each with two segments or more; evenly spread ones of them are used.
        effects: Of known places, on the residuals of each, `(3 S,)`; none by default.
    """
    chosen = range(0, len(segments), max(1, len(segments) // ROUGHNESS_SAMPLE))
    return float(
        np.median(
            [
                _likeliest_roughness(
                    segments[number],
                    segments[number].residual.reshape(-1) - (0.0 if effects is None else effects[number]),
                )
                for number in chosen
            ]
        )
    )


def _likeliest_roughness(segments: Segments, residual: Array) -> float:
    """Return the likeliest roughness of one recording, by likelihood restricted given its robot."""
    jacobian = segments.jacobian.reshape(-1, 3)

    def negative_log_likelihood(log_roughness: float) -> float:
        factor = np.linalg.cholesky(segments.covariance(math.exp(log_roughness)))
        white = np.linalg.solve(factor, np.column_stack([residual, jacobian]))
        basis, triangle = np.linalg.qr(white[:, 1:])
        left = white[:, 0] - basis @ (basis.T @ white[:, 0])
        weights = np.log(np.diag(factor)).sum() + np.log(np.abs(np.diag(triangle))).sum()
        return float(weights + 0.5 * left @ left)

    bounds = math.log(MIN_ROUGHNESS), math.log(MAX_ROUGHNESS)
    best = minimize_scalar(negative_log_likelihood, bounds=bounds, method="bounded", options={"xatol": 0.01})
    return math.exp(best.x)
