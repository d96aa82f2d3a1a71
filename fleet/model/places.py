"""Bad places of the floor, found one after the other on the score map and fitted together.

The places that stand out most are taken, all that are known are fitted together beside every robot's
parameters, and the map is made anew of what they leave, until nothing stands out. What stands out is judged
against the map's own scatter (empirical null: Efron, Large-scale simultaneous hypothesis testing, JASA 2004)
and against the number of candidates (Bonferroni), so that one night in a hundred shows a place that is none.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.ndimage import label
from scipy.stats import chi2

from omnimate.fleet.crossings import CELL
from omnimate.fleet.model.edges import edges_of, errors_of
from omnimate.fleet.model.effects import FREEDOM, effects_of, floors_of
from omnimate.fleet.model.evidence import AllCrossings
from omnimate.fleet.model.scores import LARGEST, REACH, score_map
from omnimate.fleet.morning import SEPARATE, BadPlace, PlaceEffect

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.fleet.model.evidence import Evidence
    from omnimate.fleet.model.scores import Grid, ScoreMap
    from omnimate.vehicle.se2 import Array

FALSE_NIGHT = 0.01  # probability that a night shows a place where there is none
REACHES = (0.3, 0.5, 0.8, LARGEST)  # [m] radii of places that are told apart
WEAKEST = 0.25  # of the gain of the strongest one, that others must have to be taken in the same round
ROUNDS = 30  # of places that stand out; in the last one nothing does
WINDOW = 0.5 * SEPARATE  # [m] around a place, in which it and no other is located
ENOUGH = 20  # crossings, below which a place may be somewhere else along the few ways over it
FARTHEST = REACH  # [m] standard deviation of a place's position, beyond which nobody knows where to look


def find_places(
    evidence: Sequence[Evidence], grid: Grid, known: Sequence[BadPlace] = ()
) -> tuple[BadPlace, ...]:
    """Return the bad places that recordings of a fleet show, the clearest first.

    Args:
        evidence: Of the recordings.
        grid: Cells of the floor, on which all crossings lie.
        known: Places to begin with, such as those of the night before; they are located and judged anew.
    """
    crossings = AllCrossings(evidence)
    places = _fit_with_edges(crossings, known)
    for _ in range(ROUNDS):
        new, least = _outstanding(crossings, grid, places)
        if not new:
            break
        places = _fit(crossings, (*places, *new))
        located = _located(places[-len(new) :], places, crossings, grid)
        places = _fit(crossings, (*places[: -len(new)], *located))
        places = _fit_with_edges(crossings, places)
    places = _fit_with_edges(crossings, _located(places, places, crossings, grid))
    places = _fit(crossings, _sure(places))
    while places:
        weakest = min(places, key=lambda place: place.gain / least[place.effect])
        if weakest.gain >= least[weakest.effect]:
            break
        places = _fit(crossings, [place for place in places if place is not weakest])
    places = _fit_with_edges(crossings, places)  # those that went had moved the others
    places = _fit_with_edges(crossings, _located(places, places, crossings, grid))
    places = _fit(crossings, _sure(places))
    return tuple(sorted(places, key=lambda place: -place.gain))


def _outstanding(
    crossings: AllCrossings, grid: Grid, known: Sequence[BadPlace]
) -> tuple[list[BadPlace], dict[PlaceEffect, float]]:
    """Return the places that stand out most beside known ones, and the gain that each effect needs for it.

    Where ways of few directions cross a place, what stands out is a ridge along them, metres long. All that
    stands out together may be the same place: it gives one place, and whether there is another one shows when
    that is located and fitted.
    """
    gains = _gains(score_map(crossings.evidence, floors_of(known, crossings), grid))
    least = _least(gains)
    surplus = {effect: gain / least[effect] for effect, gain in gains.items()}
    best = np.maximum(surplus["loss"], surplus["creep"])
    for place in known:
        best[grid.around(place.x, place.y, SEPARATE)] = 0.0
    strongest, new = max(1.0, WEAKEST * float(best.max())), []
    together, _ = label(best >= strongest, np.ones((3, 3)))
    while best.max() >= strongest:
        x, y = (int(at) for at in np.unravel_index(int(np.argmax(best)), best.shape))
        effect: PlaceEffect = "loss" if surplus["loss"][x, y] >= surplus["creep"][x, y] else "creep"
        new.append(_unfitted(effect, grid.place((x, y))))
        best[(together == together[x, y]) | grid.around(new[-1].x, new[-1].y, SEPARATE)] = 0.0
    return new, least


def _gains(scores: ScoreMap) -> dict[PlaceEffect, Array]:
    return {"loss": scores.gain_of_loss(), "creep": scores.gain_of_creep()}


def _least(gains: dict[PlaceEffect, Array]) -> dict[PlaceEffect, float]:
    """Return the gain that stands out: for each effect, from the map's own scatter."""
    candidates = max(1, sum(int((gain > 0.0).sum()) for gain in gains.values()))
    least = {}
    for effect, gain in gains.items():
        freedom = FREEDOM[effect]
        seen = gain[gain > 0.0]
        scale = float(np.median(seen)) / float(chi2.median(freedom)) if len(seen) else 1.0
        least[effect] = max(1.0, scale) * float(chi2.isf(FALSE_NIGHT / candidates, freedom))
    return least


def _unfitted(effect: PlaceEffect, at: tuple[float, float]) -> BadPlace:
    nothing = np.zeros(FREEDOM[effect])
    return BadPlace(effect, *at, REACH, CELL**2 * np.eye(2), nothing, nothing, 0.0, 0)


def _sure(places: Sequence[BadPlace]) -> list[BadPlace]:
    """Return the places that are no part of a stronger one, and of which is known where and what they are."""
    sure = [place for place in places if _is_sure(place)]
    return [
        place
        for place in sure
        if not any(
            other.gain > place.gain and math.hypot(other.x - place.x, other.y - place.y) < WINDOW
            for other in sure
        )
    ]


def _is_sure(place: BadPlace) -> bool:
    """Return whether a place is crossed often enough, takes way and gives none, and lies where it is said."""
    spread = math.sqrt(float(np.linalg.eigvalsh(place.covariance)[-1]))
    is_possible = place.effect == "creep" or place.size[0] > 0.0
    return place.crossings >= ENOUGH and is_possible and spread < FARTHEST


def _fit_with_edges(crossings: AllCrossings, places: Sequence[BadPlace]) -> tuple[BadPlace, ...]:
    """Return places fitted together, and state the errors of the crossings of their edges."""
    crossings.doubt({})
    places = edges_of(_fit(crossings, places), crossings)
    crossings.doubt(errors_of(places, crossings))
    return _fit(crossings, places)


def _fit(crossings: AllCrossings, places: Sequence[BadPlace]) -> tuple[BadPlace, ...]:
    """Return places with their sizes, fitted together beside all robots' parameters."""
    edges = np.cumsum([0, *(len(place.size) for place in places)])
    information, score = np.zeros((edges[-1], edges[-1])), np.zeros(edges[-1])
    effects = [effects_of(place, crossings) for place in places]
    for number in sorted(set().union(*effects)):
        single = crossings.evidence[number]
        there = [place for place, effect in enumerate(effects) if number in effect]
        columns = np.concatenate([np.arange(edges[place], edges[place + 1]) for place in there])
        matrix = np.column_stack([effects[place][number] for place in there])
        weighed = single.floor_precision @ matrix
        information[np.ix_(columns, columns)] += matrix.T @ weighed
        score[columns] += weighed.T @ single.residual
    covariance = np.linalg.pinv(information)
    sizes, sigmas = covariance @ score, np.sqrt(np.maximum(np.diag(covariance), 0.0))
    fitted = []
    for place, effect, start, end in zip(places, effects, edges[:-1], edges[1:], strict=True):
        mine = slice(int(start), int(end))
        gain = sizes[mine] @ np.linalg.pinv(covariance[mine, mine]) @ sizes[mine]
        crossed = sum(
            int(matrix.reshape(-1, 3 * matrix.shape[1]).any(axis=1).sum()) for matrix in effect.values()
        )
        fitted.append(
            replace(place, size=sizes[mine], sigma=sigmas[mine], gain=float(gain), crossings=crossed)
        )
    return tuple(fitted)


def _located(
    some: Sequence[BadPlace], places: Sequence[BadPlace], crossings: AllCrossings, grid: Grid
) -> list[BadPlace]:
    """Return some of the places, each located on the map of what all others leave, with the others' edges."""
    floors = floors_of(places, crossings)
    errors = [(place, errors_of([place], crossings)) for place in places]
    located = []
    for place in some:
        mine = effects_of(place, crossings)
        near, left = [], []
        for number, rows in crossings.near(place.x, place.y, WINDOW + 2.0 * CELL + LARGEST):
            others = [each[number] for other, each in errors if other is not place and number in each]
            single = crossings.sure[number].less_sure(others)
            near.append(replace(single, crossings=single.crossings.some(rows)))
            left.append(floors[number] - (mine[number] @ place.size if number in mine else 0.0))
        located.append(_locate(place, near, left, grid))
    return located


def _locate(place: BadPlace, near: Sequence[Evidence], left: Sequence[Array], grid: Grid) -> BadPlace:
    """Return a place at the top of the likelihood around it, of the likeliest reach.

    Args:
        place: Place roughly where it is.
        near: Recordings that come near, with their crossings there.
        left: What all other places make of their residuals, `(3 S,)` each.
        grid: Cells of the floor.
    """
    maps = {reach: _gains(score_map(near, left, grid, reach))[place.effect] for reach in REACHES}
    window = grid.around(place.x, place.y, WINDOW)
    reach = max(maps, key=lambda reach: float(maps[reach][window].max()))
    gain = np.where(window, maps[reach], -np.inf)
    top = np.array(np.unravel_index(int(np.argmax(gain)), gain.shape))
    top = np.clip(top, 2, np.array(gain.shape) - 3)
    shift, spread = _paraboloid(maps[reach][top[0] - 2 : top[0] + 3, top[1] - 2 : top[1] + 3])
    x, y = grid.place((float(top[0] + shift[0]), float(top[1] + shift[1])))
    return replace(place, x=x, y=y, reach=reach, covariance=CELL**2 * spread)


def _paraboloid(gain: Array) -> tuple[Array, Array]:
    """Return where a paraboloid through gains `(5, 5)` has its top, from the middle, and its covariance.

    Both are in cells; half of the gain is the log likelihood. The covariance holds the cell's size, too.
    """
    x, y = (offset.ravel() for offset in np.meshgrid(*2 * [np.arange(-2.0, 3.0)], indexing="ij"))
    terms = np.column_stack([np.ones(25), x, y, 0.5 * x * x, x * y, 0.5 * y * y])
    _, by_x, by_y, xx, xy, yy = np.linalg.lstsq(terms, 0.5 * gain.ravel(), rcond=None)[0]
    curvature = -np.array([[xx, xy], [xy, yy]])
    if np.linalg.eigvalsh(curvature)[0] <= 0.0:
        return np.zeros(2), 4.0 * np.eye(2)
    shift = np.clip(np.linalg.solve(curvature, np.array([by_x, by_y])), -1.0, 1.0)
    return shift, np.linalg.inv(curvature) + np.eye(2) / 12.0
