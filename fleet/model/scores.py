"""Score maps of the floor: the evidence for a bad place around each cell, given robots and known places.

Each cell is the centre of a candidate, a disc in which wheels lose a part of their travel (loss), or trucks
creep along x and y (creep). The score is the derivative of the log likelihood by the size of the effect at 0,
and the information is its variance. The score test needs no fit (Rao, 1948).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.fleet.model.evidence import fraction_inside
from omnimate.fleet.segments import CELL
from omnimate.vehicle.compiled import Array, IntArray, compiled

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from omnimate.fleet.model.evidence import Evidence
    from omnimate.fleet.report import PlaceEffect

SEARCH_RADIUS = 0.5  # [m] radius of a candidate before it is located (assumption)
MAX_RADIUS = 1.2  # [m] largest radius of a place (assumption)


@dataclass(frozen=True, slots=True)
class Grid:
    """The cells of a floor.

    `first` is the number of the first cell along x and along y, `shape` the number of cells.
    """

    first: tuple[int, int]
    shape: tuple[int, int]

    def position(self, cell: tuple[float, float]) -> tuple[float, float]:
        """Return x and y [m] of a point, given in cells from the first one; whole numbers are centres."""
        return (self.first[0] + cell[0]) * CELL, (self.first[1] + cell[1]) * CELL

    def around(self, x: float, y: float, reach: float) -> NDArray[np.bool_]:
        """Return which cells have their centre within a distance `reach` [m] of a point [m], `(X, Y)`."""
        from_x = (self.first[0] + np.arange(self.shape[0])) * CELL - x
        from_y = (self.first[1] + np.arange(self.shape[1])) * CELL - y
        distance = np.hypot(from_x[:, np.newaxis], from_y)
        return np.asarray(distance <= reach, np.bool_)


@dataclass(frozen=True, slots=True)
class ScoreMap:
    """Scores and information of all candidates."""

    score: Array  # scores of loss, creep along x and creep along y, `(X, Y, 3)`
    information: Array  # information on loss; on creep the elements xx, xy and yy, `(X, Y, 4)`

    def gains(self) -> dict[PlaceEffect, Array]:
        """Return twice the gain in log likelihood of the best size of each effect, `(X, Y)`.

        Without a place, that of creep is chi-squared with 2 degrees of freedom, and that of loss with 1; it
        is 0 where the loss would be negative.
        """
        information, score = self.information[..., 0], self.score[..., 0]
        known = information > 0.0
        loss = np.where(known & (score > 0.0), score**2 / np.where(known, information, 1.0), 0.0)
        xx, xy, yy = np.moveaxis(self.information[..., 1:], -1, 0)
        determinant = xx * yy - xy * xy
        regular = determinant > 1e-9 * xx * yy
        x, y = self.score[..., 1], self.score[..., 2]
        creep = np.where(
            regular, (yy * x * x - 2.0 * xy * x * y + xx * y * y) / np.where(regular, determinant, 1.0), 0.0
        )
        return {"loss": loss, "creep": creep}


def make_grid(evidence: Sequence[Evidence]) -> Grid:
    """Return the grid of all crossed cells, with a margin of the largest radius."""
    edge = round(MAX_RADIUS / CELL) + 2
    low = np.min([recording.crossings.cell.min(axis=0) for recording in evidence], axis=0) - edge
    high = np.max([recording.crossings.cell.max(axis=0) for recording in evidence], axis=0) + edge
    shape = high - low + 1
    return Grid((int(low[0]), int(low[1])), (int(shape[0]), int(shape[1])))


def disc_cells(reach: float) -> tuple[IntArray, Array]:
    """Return the cells of a disc of radius `reach` [m]: offsets `(M, 2)`, and fractions inside `(M,)`."""
    edge = round(reach / CELL) + 1
    offsets = np.array([(x, y) for x in range(-edge, edge + 1) for y in range(-edge, edge + 1)], np.int64)
    inside = fraction_inside(CELL * np.hypot(offsets[:, 0], offsets[:, 1]), reach)
    return offsets[inside > 0.0], inside[inside > 0.0]


def score_map(
    evidence: Sequence[Evidence], effects: Sequence[Array], grid: Grid, reach: float = SEARCH_RADIUS
) -> ScoreMap:
    """Return the scores of all candidates.

    `effects` are those of known places on the residuals of each recording, `(3 S,)`; `reach` is the radius of
    the candidates' discs [m].
    """
    offsets, parts = disc_cells(reach)
    score, information = np.zeros((*grid.shape, 3)), np.zeros((*grid.shape, 4))
    slots = np.full(grid.shape, -1, np.int64)
    for recording, effect in zip(evidence, effects, strict=True):
        crossings = recording.crossings
        _add_recording(
            score,
            information,
            slots,
            crossings.segment.astype(np.int64),
            crossings.cell.astype(np.int64) - np.array(grid.first),
            np.column_stack([crossings.loss, crossings.creep]).astype(np.float64),
            recording.floor_precision,
            recording.floor_precision @ (recording.residual - effect),
            offsets,
            parts,
        )
    return ScoreMap(score, information)


@compiled
def _add_recording(
    score: Array,
    information: Array,
    slots: IntArray,
    segment: IntArray,
    cell: IntArray,
    rows: Array,
    precision: Array,
    weighed: Array,
    offsets: IntArray,
    parts: Array,
) -> None:
    """Add one recording's scores and information to the map; `slots` is -1 everywhere, before and after."""
    candidates = np.zeros((len(segment) * len(offsets), 2), np.int64)
    count = _number_candidates(slots, candidates, cell, offsets)
    effects = np.zeros((count, len(weighed) // 3, 4))  # effects of candidates on segments: loss (3), creep
    for row in range(len(segment)):
        for number in range(len(offsets)):
            slot = slots[cell[row, 0] + offsets[number, 0], cell[row, 1] + offsets[number, 1]]
            for column in range(4):
                effects[slot, segment[row], column] += parts[number] * rows[row, column]
    for slot in range(count):
        x, y = candidates[slot]
        slots[x, y] = -1
        _add_candidate(score[x, y], information[x, y], effects[slot], precision, weighed)


@compiled
def _number_candidates(slots: IntArray, candidates: IntArray, cell: IntArray, offsets: IntArray) -> int:
    """Number the candidates that a recording crosses, fill `candidates` with their cells, return how many."""
    count = 0
    for row in range(len(cell)):
        for number in range(len(offsets)):
            x, y = cell[row, 0] + offsets[number, 0], cell[row, 1] + offsets[number, 1]
            if slots[x, y] < 0:
                slots[x, y] = count
                candidates[count, 0], candidates[count, 1] = x, y
                count += 1
    return count


@compiled
def _add_candidate(
    score: Array, information: Array, effects: Array, precision: Array, weighed: Array
) -> None:
    """Add the scores and information of the effects `(S, 4)` of a candidate."""
    for first in range(len(effects)):
        if not effects[first].any():
            continue
        creep = effects[first, 3]
        for axis in range(3):
            score[0] += effects[first, axis] * weighed[3 * first + axis]
        score[1] += creep * weighed[3 * first]
        score[2] += creep * weighed[3 * first + 1]
        for second in range(len(effects)):
            for axis in range(3):
                for other in range(3):
                    weight = precision[3 * first + axis, 3 * second + other]
                    information[0] += effects[first, axis] * weight * effects[second, other]
            both = creep * effects[second, 3]
            information[1] += both * precision[3 * first, 3 * second]
            information[2] += both * precision[3 * first, 3 * second + 1]
            information[3] += both * precision[3 * first + 1, 3 * second + 1]
