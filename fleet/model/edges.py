"""Edges: the scatter of a place's effect from one crossing to the next.

The model of a place is a disc. A joint is a line, and the most probable path between two poses differs from
the path that was driven, so that the effect of a crossing differs from that of the disc, above all near its
edge. For a strong place this error is far larger than the floor's roughness. Without a model of it, hundreds
of crossings would make the position too certain, and a second place next to it probable. Each crossing
therefore has an additional independent error: the effect of the disc within half a cell of its edge, times a
factor for each place, which is estimated from the place's crossings.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import brentq

from omnimate.calib.distributions import chi2_quantile
from omnimate.fleet.segments import CELL

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

    from omnimate.fleet.model.evidence import FleetEvidence
    from omnimate.fleet.report import BadPlace
    from omnimate.vehicle.se2 import Array

MAX_EDGE = 3.0  # [half cells] of scatter: 0.375 m, more than the smallest radius of a place
_CHI2_MEDIAN = chi2_quantile(0.5, 1)


def estimate_edges(places: Sequence[BadPlace], fleet: FleetEvidence) -> tuple[BadPlace, ...]:
    """Return fitted places with `edge`, the scatter of their edges, from the residuals of their crossings."""
    effects = fleet.sum_effects(places)
    return tuple(replace(place, edge=_estimate_edge(place, fleet, effects)) for place in places)


def crossing_errors(places: Sequence[BadPlace], fleet: FleetEvidence) -> dict[int, Array]:
    """Return the errors at the places' edges by recording, `(3 S, K)`, one standard deviation per column."""
    columns: dict[int, list[Array]] = {}
    for place in places:
        for number, segment, effect in _edge_effects(place, fleet):
            column = np.zeros((len(fleet.recordings[number].residual) // 3, len(segment), 3))
            column[segment, np.arange(len(segment))] = place.edge * effect
            columns.setdefault(number, []).append(column.transpose(0, 2, 1).reshape(-1, len(segment)))
    return {number: np.concatenate(parts, axis=1) for number, parts in columns.items()}


def _edge_effects(place: BadPlace, fleet: FleetEvidence) -> Iterator[tuple[int, NDArray[np.intp], Array]]:
    """Yield (recording, segments that cross a place's edge `(K,)`, effect of half a cell `(K, 3)`)."""
    wide, narrow = (
        fleet.effects_of(replace(place, reach=place.reach + side * 0.5 * CELL)) for side in (1.0, -1.0)
    )
    for number, effect in wide.items():
        change = ((effect - narrow.get(number, 0.0)) @ place.size).reshape(-1, 3)
        segment = np.flatnonzero(change.any(axis=1))
        if len(segment):
            yield number, segment, change[segment]


def _estimate_edge(place: BadPlace, fleet: FleetEvidence, effects: Sequence[Array]) -> float:
    """Return the standard deviation of a place's edge [half cells] from its crossings.

    The estimate is robust: the median of the normalised squares is that of a chi-squared variable.
    """
    shifts, variance = [np.zeros(0)], [np.zeros(0)]
    for number, segment, effect in _edge_effects(place, fleet):
        recording = fleet.recordings[number]
        count = len(recording.residual) // 3
        weighed = recording.floor_precision @ (recording.residual - effects[number])
        weights = recording.floor_precision.reshape(count, 3, count, 3)[segment, :, segment, :]
        information = np.einsum("ki,kij,kj->k", effect, weights, effect)
        shifts.append(np.einsum("ki,ki->k", effect, weighed.reshape(count, 3)[segment]) / information)
        variance.append(1.0 / information)
    square, known = np.concatenate(shifts) ** 2, np.concatenate(variance)

    def surplus(edge: float) -> float:
        return float(np.median(square / (known + edge**2))) - _CHI2_MEDIAN

    if not len(square) or surplus(0.0) <= 0.0:
        return 0.0
    return float(brentq(surplus, 0.0, MAX_EDGE)) if surplus(MAX_EDGE) < 0.0 else MAX_EDGE
