"""Edges: by how much what a place does differs from one crossing to the next.

A place is a disc of cells, a joint is a line, and the likeliest path between two poses lies beside the path
that was driven: a crossing, above all one that grazes the place, does a little more or less than the disc
says. Of a strong place that is far more than the floor's roughness. Hundreds of crossings would then make its
position look surer than it is, and another place next to it likely. So each crossing has an error besides,
independent of the others: what the disc does within half a cell of its edge, times a factor for each place,
which its crossings tell.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import brentq
from scipy.stats import chi2

from omnimate.fleet.crossings import CELL
from omnimate.fleet.model.effects import effects_of, floors_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

    from omnimate.fleet.model.evidence import AllCrossings
    from omnimate.fleet.morning import BadPlace
    from omnimate.vehicle.se2 import Array

MOST = 3.0  # half cells: an edge that is less sure than this is no edge of a disc of 0.3 m
_MEDIAN = float(chi2.median(1))


def edges_of(places: Sequence[BadPlace], crossings: AllCrossings) -> tuple[BadPlace, ...]:
    """Return fitted places with how sure their edges are, by the scatter of what their crossings leave."""
    floors = floors_of(places, crossings)
    return tuple(replace(place, edge=_edge(place, crossings, floors)) for place in places)


def errors_of(places: Sequence[BadPlace], crossings: AllCrossings) -> dict[int, Array]:
    """Return the errors of crossings by recording, `(3 S, K)`: one standard deviation in a column."""
    columns: dict[int, list[Array]] = {}
    for place in places:
        for number, way, effect in _at_edge(place, crossings):
            column = np.zeros((len(crossings.evidence[number].residual) // 3, len(way), 3))
            column[way, np.arange(len(way))] = place.edge * effect
            columns.setdefault(number, []).append(column.transpose(0, 2, 1).reshape(-1, len(way)))
    return {number: np.concatenate(parts, axis=1) for number, parts in columns.items()}


def _at_edge(place: BadPlace, crossings: AllCrossings) -> Iterator[tuple[int, NDArray[np.intp], Array]]:
    """Yield recordings, their ways near a place's edge, and what half a cell makes of these `(K, 3)`."""
    wide, narrow = (
        effects_of(replace(place, reach=place.reach + side * 0.5 * CELL), crossings) for side in (1.0, -1.0)
    )
    for number, effect in wide.items():
        change = ((effect - narrow.get(number, 0.0)) @ place.size).reshape(-1, 3)
        way = np.flatnonzero(change.any(axis=1))
        if len(way):
            yield number, way, change[way]


def _edge(place: BadPlace, crossings: AllCrossings, floors: Sequence[Array]) -> float:
    """Return the standard deviation of a place's edge [half cells], robustly, from its crossings."""
    seen, variance = [np.zeros(0)], [np.zeros(0)]
    for number, way, effect in _at_edge(place, crossings):
        single = crossings.evidence[number]
        ways = len(single.residual) // 3
        left = (single.floor_precision @ (single.residual - floors[number])).reshape(ways, 3)[way]
        weights = single.floor_precision.reshape(ways, 3, ways, 3)[way, :, way, :]
        information = np.einsum("ki,kij,kj->k", effect, weights, effect)
        seen.append(np.einsum("ki,ki->k", effect, left) / information)
        variance.append(1.0 / information)
    square, known = np.concatenate(seen) ** 2, np.concatenate(variance)

    def surplus(edge: float) -> float:
        return float(np.median(square / (known + edge**2))) - _MEDIAN

    if not len(square) or surplus(0.0) <= 0.0:
        return 0.0
    return float(brentq(surplus, 0.0, MOST)) if surplus(MOST) < 0.0 else MOST
