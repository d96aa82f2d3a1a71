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

MAX_ROUNDS = 4  # iterations in which places and roughness are estimated alternately
ROUGHNESS_TOLERANCE = 0.05  # relative change of the roughness below which the iteration has converged
MAX_SAMPLE = 1000  # recordings that are used in the iteration; the last step uses all
ROUGHNESS_SAMPLE = 200  # recordings from which the roughness is estimated
MIN_ROUGHNESS, MAX_ROUGHNESS = 5e-5, 5e-3  # [m/sqrt(m)] of a steel plate, and of cobbles (assumption)


@dataclass(frozen=True, slots=True)
class Floor:
    """A floor.

    The most significant place is the first; the roughness is that outside of these [m/sqrt(m)].
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

    Bad places that are not known yet increase the estimated roughness, and so make themselves less
    significant. Places and roughness are therefore estimated alternately until the roughness converges, from
    at most `MAX_SAMPLE` recordings; weak places are then found with all recordings.

    There is at least one recording; the search begins with the known places.
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
    """Return the floor's roughness: the median of the recordings' maximum likelihood estimates [m/sqrt(m)].

    The median is robust against faulty robots.

    Each recording has two segments or more, and about `ROUGHNESS_SAMPLE` recordings are used; `effects` are
    those of known places on the residuals of each recording, `(3 S,)`.
    """
    chosen = range(0, len(segments), max(1, len(segments) // ROUGHNESS_SAMPLE))
    return float(
        np.median(
            [
                _maximum_likelihood_roughness(
                    segments[number],
                    segments[number].residual.reshape(-1) - (0.0 if effects is None else effects[number]),
                )
                for number in chosen
            ]
        )
    )


def _maximum_likelihood_roughness(segments: Segments, residual: Array) -> float:
    """Return the roughness of one recording by restricted maximum likelihood (unknown robot)."""
    jacobian = segments.jacobian.reshape(-1, 3)

    def negative_log_likelihood(log_roughness: float) -> float:
        factor = np.linalg.cholesky(segments.covariance(math.exp(log_roughness)))
        white = np.linalg.solve(factor, np.column_stack([residual, jacobian]))
        basis, triangle = np.linalg.qr(white[:, 1:])
        residuals = white[:, 0] - basis @ (basis.T @ white[:, 0])
        log_determinants = np.log(np.diag(factor)).sum() + np.log(np.abs(np.diag(triangle))).sum()
        return float(log_determinants + 0.5 * residuals @ residuals)

    bounds = math.log(MIN_ROUGHNESS), math.log(MAX_ROUGHNESS)
    best = minimize_scalar(negative_log_likelihood, bounds=bounds, method="bounded", options={"xatol": 0.01})
    return math.exp(best.x)
