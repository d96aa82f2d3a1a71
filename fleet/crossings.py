"""Crossings: which cells of the floor each way goes over, and how a loss of way there would move its end."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from omnimate.fleet.segments import Steps
    from omnimate.vehicle.se2 import Array

CELL = 0.25  # [m] side of a cell; cells lie on whole multiples of it


@dataclass(frozen=True, slots=True)
class Crossings:
    """One row for each way and each cell that one of its wheels, or its middle, goes over.

    Attributes:
        way: Number of the way, `(K,)`.
        cell: Number of the cell along x and along y, `(K, 2)`.
        loss: What the residual would gain if wheels lost all of their travel in the cell: derivative by the
            part that is lost [m, m, rad], `(K, 3)`.
        creep: Way of the truck's middle over the cell [m], `(K,)`: derivative of the residual's x and y by
            creep along x and y.
    """

    way: NDArray[np.int32]
    cell: NDArray[np.int32]
    loss: Array
    creep: Array

    def some(self, rows: NDArray[np.int64]) -> Crossings:
        """Return some of the rows."""
        return Crossings(self.way[rows], self.cell[rows], self.loss[rows], self.creep[rows])


def crossings_of(steps: Steps) -> Crossings:
    """Return the crossings of all ways."""
    count = len(steps.way)
    middle = 0.5 * (steps.left + steps.right)
    places = np.concatenate([steps.left, steps.right, middle])
    rows = np.zeros((3 * count, 4))
    rows[:count, :3] = -steps.gain[:, :, 0] * steps.travel[:, :1]
    rows[count : 2 * count, :3] = -steps.gain[:, :, 1] * steps.travel[:, 1:]
    rows[2 * count :, 3] = np.abs(steps.travel.mean(axis=1))
    cells = np.round(places / CELL).astype(np.int64)
    keys = np.column_stack([np.tile(steps.way, 3), cells])
    lowest = keys.min(axis=0)
    span = keys.max(axis=0) - lowest + 1
    shifted = keys - lowest
    packed = (shifted[:, 0] * span[1] + shifted[:, 1]) * span[2] + shifted[:, 2]
    unique, owner = np.unique(packed, return_inverse=True)
    sums = np.column_stack([np.bincount(owner, rows[:, column], len(unique)) for column in range(4)])
    rest, y = np.divmod(unique, span[2])
    way, x = np.divmod(rest, span[1])
    return Crossings(
        (way + lowest[0]).astype(np.int32),
        np.column_stack([x + lowest[1], y + lowest[2]]).astype(np.int32),
        np.asarray(sums[:, :3], np.float64),
        np.asarray(sums[:, 3], np.float64),
    )
