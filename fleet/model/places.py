"""Bad places of the floor, found one after the other on the score map and fitted together.

In each round the most significant places of the map are added, all places are fitted together with the
robots' parameters projected out, and the map is computed again from the residuals, until no place is
significant. The threshold is scaled by the median of the map (empirical null: Efron, Large-scale simultaneous
hypothesis testing, JASA 2004), and its level divided by the number of candidates (Bonferroni), so that one
day in a hundred has a false place.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.ndimage import label

from omnimate.calib.distributions import chi2_quantile, chi2_upper_limit
from omnimate.fleet.model.edges import crossing_errors, estimate_edges
from omnimate.fleet.model.evidence import FREEDOM
from omnimate.fleet.model.scores import MAX_RADIUS, SEARCH_RADIUS, make_grid, score_map
from omnimate.fleet.report import MIN_SEPARATION, BadPlace, PlaceEffect
from omnimate.fleet.segments import CELL

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.fleet.model.evidence import Evidence, FleetEvidence
    from omnimate.fleet.model.scores import Grid
    from omnimate.vehicle.se2 import Array

FALSE_ALARM_RATE = 0.01  # probability of a false place on a day
RADII = (0.3, 0.5, 0.8, MAX_RADIUS)  # [m] radii of places that are fitted
MIN_RELATIVE_GAIN = 0.25  # gain relative to the strongest place, for a place to be added in the same round
MAX_ROUNDS = 30  # limit of the rounds in which places are added
WINDOW = 0.5 * MIN_SEPARATION  # [m] distance from a place within which its maximum is searched
MIN_CROSSINGS = 20  # segments; with fewer a place may be elsewhere along these (assumption)
# [m] largest standard deviation of a position that is reported (assumption).
MAX_POSITION_SIGMA = SEARCH_RADIUS


def find_places(fleet: FleetEvidence, known: Sequence[BadPlace] = ()) -> tuple[BadPlace, ...]:
    """Return the bad places of a floor, the most significant first.

    The errors at the edges of the places are set in `fleet`. Known places, such as those of the day before,
    are located and tested again.
    """
    grid = make_grid(fleet.recordings)
    places = _fit_with_edges(fleet, known)
    for _ in range(MAX_ROUNDS):
        new, threshold = _find_significant(fleet, grid, places)
        if not new:
            break
        places = _fit(fleet, (*places, *new))
        located = _relocate(places[-len(new) :], places, fleet, grid)
        places = _fit(fleet, (*places[: -len(new)], *located))
        places = _fit_with_edges(fleet, places)
    places = _fit_with_edges(fleet, _relocate(places, places, fleet, grid))
    places = _fit(fleet, _select_certain(places))
    while places:
        weakest = min(places, key=lambda place: place.gain / threshold[place.effect])
        if weakest.gain >= threshold[weakest.effect]:
            break
        places = _fit(fleet, [place for place in places if place is not weakest])
    places = _fit_with_edges(fleet, places)  # the removed ones had moved the others
    places = _fit_with_edges(fleet, _relocate(places, places, fleet, grid))
    places = _fit(fleet, _select_certain(places))
    return tuple(sorted(places, key=lambda place: -place.gain))


def _find_significant(
    fleet: FleetEvidence, grid: Grid, known: Sequence[BadPlace]
) -> tuple[list[BadPlace], dict[PlaceEffect, float]]:
    """Return the most significant places given known ones, and the threshold of the gain for each effect.

    If the segments over a place have few directions, the map has a ridge along them, metres long. Connected
    cells above the threshold are therefore taken as one place; a second one is found in a later round.
    """
    gains = score_map(fleet.recordings, fleet.sum_effects(known), grid).gains()
    threshold = _gain_thresholds(gains)
    relative = {effect: gain / threshold[effect] for effect, gain in gains.items()}
    best = np.maximum(relative["loss"], relative["creep"])
    for place in known:
        best[grid.around(place.x, place.y, MIN_SEPARATION)] = 0.0
    strongest, new = max(1.0, MIN_RELATIVE_GAIN * float(best.max())), []
    connected, _ = label(best >= strongest, np.ones((3, 3)))
    while best.max() >= strongest:
        x, y = (int(index) for index in np.unravel_index(int(np.argmax(best)), best.shape))
        effect: PlaceEffect = "loss" if relative["loss"][x, y] >= relative["creep"][x, y] else "creep"
        unknown = np.zeros(FREEDOM[effect])
        centre = grid.position((x, y))
        new.append(BadPlace(effect, *centre, SEARCH_RADIUS, CELL**2 * np.eye(2), unknown, unknown, 0.0, 0))
        best[(connected == connected[x, y]) | grid.around(*centre, MIN_SEPARATION)] = 0.0
    return new, threshold


def _gain_thresholds(gains: dict[PlaceEffect, Array]) -> dict[PlaceEffect, float]:
    """Return the threshold of the gain for each effect, scaled by the median of the map `(X, Y)`."""
    candidates = max(1, sum(int((gain > 0.0).sum()) for gain in gains.values()))
    thresholds = {}
    for effect, gain in gains.items():
        freedom = FREEDOM[effect]
        positive = gain[gain > 0.0]
        scale = float(np.median(positive)) / chi2_quantile(0.5, freedom) if len(positive) else 1.0
        thresholds[effect] = max(1.0, scale) * float(
            chi2_upper_limit(FALSE_ALARM_RATE / candidates, [freedom])[0]
        )
    return thresholds


def _select_certain(places: Sequence[BadPlace]) -> list[BadPlace]:
    """Return the places that pass `_is_certain`, without those within `WINDOW` of a stronger one."""
    certain = [place for place in places if _is_certain(place)]
    return [
        place
        for place in certain
        if not any(
            other.gain > place.gain and math.hypot(other.x - place.x, other.y - place.y) < WINDOW
            for other in certain
        )
    ]


def _is_certain(place: BadPlace) -> bool:
    """Return whether a place has enough crossings, a loss that is positive, and an accurate position."""
    spread = math.sqrt(float(np.linalg.eigvalsh(place.covariance)[-1]))
    is_possible = place.effect == "creep" or place.size[0] > 0.0
    return place.crossings >= MIN_CROSSINGS and is_possible and spread < MAX_POSITION_SIGMA


def _fit_with_edges(fleet: FleetEvidence, places: Sequence[BadPlace]) -> tuple[BadPlace, ...]:
    """Return places fitted together with the errors at their edges, which are set in `fleet`."""
    fleet.set_errors({})
    places = estimate_edges(_fit(fleet, places), fleet)
    fleet.set_errors(crossing_errors(places, fleet))
    return _fit(fleet, places)


def _fit(fleet: FleetEvidence, places: Sequence[BadPlace]) -> tuple[BadPlace, ...]:
    """Return places with sizes and gains, fitted together with the robots' parameters projected out."""
    edges = np.cumsum([0, *(len(place.size) for place in places)])
    information, score = np.zeros((edges[-1], edges[-1])), np.zeros(edges[-1])
    effects = [fleet.effects_of(place) for place in places]
    for number in sorted(set().union(*effects)):
        recording = fleet.recordings[number]
        crossed = [place for place, effect in enumerate(effects) if number in effect]
        columns = np.concatenate([np.arange(edges[place], edges[place + 1]) for place in crossed])
        matrix = np.column_stack([effects[place][number] for place in crossed])
        weighed = recording.floor_precision @ matrix
        information[np.ix_(columns, columns)] += matrix.T @ weighed
        score[columns] += weighed.T @ recording.residual
    covariance = np.linalg.pinv(information)
    sizes, sigmas = covariance @ score, np.sqrt(np.maximum(np.diag(covariance), 0.0))
    fitted = []
    for place, effect, start, end in zip(places, effects, edges[:-1], edges[1:], strict=True):
        part = slice(int(start), int(end))
        gain = float(sizes[part] @ np.linalg.pinv(covariance[part, part]) @ sizes[part])
        count = sum(
            int(matrix.reshape(-1, 3 * matrix.shape[1]).any(axis=1).sum()) for matrix in effect.values()
        )
        fitted.append(replace(place, size=sizes[part], sigma=sigmas[part], gain=gain, crossings=count))
    return tuple(fitted)


def _relocate(
    some: Sequence[BadPlace], places: Sequence[BadPlace], fleet: FleetEvidence, grid: Grid
) -> list[BadPlace]:
    """Return some of the places, each located on the map of residuals without the effect of all others."""
    sums = fleet.sum_effects(places)
    errors = [(place, crossing_errors([place], fleet)) for place in places]
    located = []
    for place in some:
        effect = fleet.effects_of(place)
        near, others = [], []
        for number, rows in fleet.near(place.x, place.y, WINDOW + 2.0 * CELL + MAX_RADIUS):
            edges = [columns[number] for other, columns in errors if other is not place and number in columns]
            recording = fleet.initial[number].with_errors(edges)
            near.append(replace(recording, crossings=recording.crossings.rows(rows)))
            others.append(sums[number] - (effect[number] @ place.size if number in effect else 0.0))
        located.append(_locate(place, near, others, grid))
    return located


def _locate(place: BadPlace, near: Sequence[Evidence], others: Sequence[Array], grid: Grid) -> BadPlace:
    """Return a place at the maximum of the likelihood within `WINDOW`, with the best of `RADII`.

    `near` is the evidence of the recordings that come near, with their crossings there, and `others` the
    effect of all other places on the residuals of each of these, `(3 S,)`.
    """
    maps = {radius: score_map(near, others, grid, radius).gains()[place.effect] for radius in RADII}
    window = grid.around(place.x, place.y, WINDOW)
    radius = max(maps, key=lambda radius: float(maps[radius][window].max()))
    gain = np.where(window, maps[radius], -np.inf)
    top = np.array(np.unravel_index(int(np.argmax(gain)), gain.shape))
    top = np.clip(top, 2, np.array(gain.shape) - 3)
    shift, spread = _fit_paraboloid(maps[radius][top[0] - 2 : top[0] + 3, top[1] - 2 : top[1] + 3])
    x, y = grid.position((float(top[0] + shift[0]), float(top[1] + shift[1])))
    return replace(place, x=x, y=y, reach=radius, covariance=CELL**2 * spread)


def _fit_paraboloid(gain: Array) -> tuple[Array, Array]:
    """Return the maximum of a paraboloid fitted to gains `(5, 5)`, from the middle, and its covariance.

    Half of the gain is the log likelihood. The covariance [cells^2] is the inverse curvature plus 1/12, the
    variance of a uniform position within a cell.
    """
    x, y = (offset.ravel() for offset in np.meshgrid(*2 * [np.arange(-2.0, 3.0)], indexing="ij"))
    terms = np.column_stack([np.ones(25), x, y, 0.5 * x * x, x * y, 0.5 * y * y])
    _, by_x, by_y, xx, xy, yy = np.linalg.lstsq(terms, 0.5 * gain.ravel(), rcond=None)[0]
    curvature = -np.array([[xx, xy], [xy, yy]])
    if np.linalg.eigvalsh(curvature)[0] <= 0.0:
        return np.zeros(2), 4.0 * np.eye(2)
    shift = np.clip(np.linalg.solve(curvature, np.array([by_x, by_y])), -1.0, 1.0)
    return shift, np.linalg.inv(curvature) + np.eye(2) / 12.0
