"""Which parameters a drive tells, and which it does not: the eigenvectors of the information matrix."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from calib.kinematics import Coordinate
    from vehicle.se2 import Array

_HOPELESS = 1e3  # doubts
_INVOLVED = 0.3  # share of an eigenvector from which a coordinate belongs to it


class Held(NamedTuple):
    """A coordinate that stays nominal.

    Attributes:
        name: of the coordinate.
        reason: in words.
        bound: Cramer-Rao bound of its direction, in units of its doubt; nan where nobody asked.
    """

    name: str
    reason: str
    bound: float


def information_bound(information: Array, free: NDArray[np.bool_]) -> Array:
    """Return the inverse `(P, P)` of the information on the free coordinates; 0 on the others."""
    bound = np.zeros_like(information)
    inside = np.ix_(free, free)
    part = information[inside]
    scale = 1.0 / np.sqrt(np.maximum(np.diag(part), 1e-300))
    bound[inside] = np.linalg.pinv(part * np.outer(scale, scale), rcond=1e-14, hermitian=True) * np.outer(
        scale, scale
    )
    return bound


def unobservable(
    coordinates: Sequence[Coordinate], information: Array, free: NDArray[np.bool_]
) -> tuple[Held, ...]:
    """Return the coordinates that the data tell worse than they are known without any drive.

    In units of the doubts, a direction whose information is below 1 is told less well than before. Its
    coordinates are held: all that belong to it by a good part. One that is known far better than the others,
    as the mean diameter is from a tape, dominates its direction and is held alone, so that the others can be
    estimated relative to it, as UMBmark does.
    """
    doubts = np.array([one.doubt for one in coordinates])
    scaled = information * np.outer(doubts, doubts)
    left = free.copy()
    held: list[Held] = []
    while left.any():
        places = np.flatnonzero(left)
        values, vectors = np.linalg.eigh(scaled[np.ix_(places, places)])
        if values[0] >= 1.0:
            break
        bound = float(max(values[0], 1e-12) ** -0.5)
        inside = places[np.abs(vectors[:, 0]) > _INVOLVED]
        others = " and ".join(coordinates[place].name for place in inside)
        for place in inside:
            one = coordinates[place]
            reason = _reason(one, bound)
            if len(inside) > 1:
                reason = f"these drives tell only a combination of {others}"
            held.append(Held(one.name, reason, bound))
        left[inside] = False
    return tuple(held)


def _reason(one: Coordinate, bound: float) -> str:
    size = one.doubt * bound
    if bound > _HOPELESS:
        return "these drives do not tell it at all"
    words = f"{1e2 * size:.1f} %" if one.unit == "1" else f"{size:.3g} {one.unit}"
    return f"these drives tell it to {words} only"
