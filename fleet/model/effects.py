"""What bad places make of the residuals of the ways that lead over them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omnimate.fleet.crossings import CELL
from omnimate.fleet.model.scores import part_inside

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.fleet.model.evidence import AllCrossings, Effects
    from omnimate.fleet.morning import BadPlace, PlaceEffect
    from omnimate.vehicle.se2 import Array

FREEDOM: dict[PlaceEffect, int] = {"loss": 1, "creep": 2}


def effects_of(place: BadPlace, crossings: AllCrossings) -> Effects:
    """Return what a place of unit size makes of the residuals of the recordings that come over it."""
    key = place.effect, place.x, place.y, place.reach
    if key not in crossings.effects:
        crossings.effects[key] = _effects(place, crossings)
    return crossings.effects[key]


def _effects(place: BadPlace, crossings: AllCrossings) -> Effects:
    effects = {}
    for number, rows in crossings.near(place.x, place.y, place.reach + CELL):
        single = crossings.evidence[number]
        from_place = CELL * single.crossings.cell[rows] - np.array([place.x, place.y])
        part = part_inside(np.hypot(from_place[:, 0], from_place[:, 1]), place.reach)
        effect = np.zeros((len(single.residual) // 3, 3, FREEDOM[place.effect]))
        way = single.crossings.way[rows]
        if place.effect == "loss":
            np.add.at(effect[:, :, 0], way, part[:, np.newaxis] * single.crossings.loss[rows])
        else:
            for axis in range(2):
                np.add.at(effect[:, axis, axis], way, part * single.crossings.creep[rows])
        if effect.any():
            effects[number] = effect.reshape(-1, FREEDOM[place.effect])
    return effects


def floors_of(places: Sequence[BadPlace], crossings: AllCrossings) -> list[Array]:
    """Return what known places make of the residuals of each recording, `(3 S,)`."""
    floors = [np.zeros(len(single.residual)) for single in crossings.evidence]
    for place in places:
        for number, effect in effects_of(place, crossings).items():
            floors[number] += effect @ place.size
    return floors
