"""Which parameters a drive identifies, by the eigenvectors of the information matrix."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from omnimate.calib.estimation.chains import Coordinate
    from omnimate.vehicle.se2 import Array

_UNIDENTIFIED = 1e3  # [prior standard deviations] a larger bound is reported as unidentified
_INVOLVED = 0.3  # smallest component of a coordinate that belongs to an eigenvector (assumption)


class Held(NamedTuple):
    """A coordinate that is held at its nominal value."""

    name: str
    reason: str
    bound: float  # Cramer-Rao bound of its direction [prior standard deviations]; nan if held by request


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
) -> tuple[tuple[Held, ...], NDArray[np.bool_]]:
    """Return the coordinates that the data identify worse than their prior does, and which are free `(P,)`.

    In units of the prior standard deviations, a direction with information below 1 adds nothing to the prior.
    All coordinates with a large component in it are held. A coordinate with a much better prior than the
    others, such as the mean diameter from a tape, dominates its direction and is held alone, so that the
    others are estimated relative to it, as in UMBmark.
    """
    sigmas = np.array([coordinate.prior_sigma for coordinate in coordinates])
    scaled = information * np.outer(sigmas, sigmas)
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
            coordinate = coordinates[place]
            reason = _reason(coordinate, bound)
            if len(inside) > 1:
                reason = f"these drives identify only a combination of {others}"
            held.append(Held(coordinate.name, reason, bound))
        left[inside] = False
    return tuple(held), left


def _reason(coordinate: Coordinate, bound: float) -> str:
    size = coordinate.prior_sigma * bound
    if bound > _UNIDENTIFIED:
        return "these drives do not identify it"
    words = f"{1e2 * size:.1f} %" if coordinate.unit == "1" else f"{size:.3g} {coordinate.unit}"
    return f"these drives identify it to {words} only"
