"""The evidence of recordings: their ways, what these go over, and what they weigh."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from omnimate.fleet.crossings import CELL

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from omnimate.fleet.crossings import Crossings
    from omnimate.fleet.segments import Segments
    from omnimate.vehicle.se2 import Array

Effects = dict[int, "Array"]  # what a place of unit size makes of residuals `(3 S, C)`, by recording


@dataclass(frozen=True, slots=True)
class Evidence:
    """What one recording says of its robot and of the floor.

    Attributes:
        robot: Name of the robot.
        kind: Type of the robot: all of a type share what is ordinary.
        day: Date, as YYYY-MM-DD.
        residual: All residuals, `(3 S,)`, as in `Segments`.
        jacobian: Their derivative by the robot's parameters, `(3 S, 3)`.
        precision: Their inverse covariance, `(3 S, 3 S)`.
        floor_precision: What of it is left beside any parameters of the robot, fitted to this recording
            alone: whatever the robot's diameters and wheelbase are, they change no score of a place.
        crossings: What the ways go over.
    """

    robot: str
    kind: str
    day: str
    residual: Array
    jacobian: Array
    precision: Array
    floor_precision: Array
    crossings: Crossings

    def robot_information(self, floor: Array) -> tuple[Array, Array]:
        """Return the information `(3, 3)` on the robot's parameters, and the score `(3,)`.

        Args:
            floor: What the floor's places make of the residuals, `(3 S,)`.
        """
        weighed = self.precision @ self.jacobian
        return self.jacobian.T @ weighed, weighed.T @ (self.residual - floor)

    def less_sure(self, errors: Sequence[Array]) -> Evidence:
        """Return the evidence with independent errors besides, one standard deviation in each column.

        Args:
            errors: Columns, `(3 S, K)` each.
        """
        if not errors:
            return self
        columns = np.concatenate(errors, axis=1)
        weighed = self.precision @ columns
        inner = np.eye(columns.shape[1]) + columns.T @ weighed
        precision = self.precision - weighed @ np.linalg.solve(inner, weighed.T)
        return replace(self, precision=precision, floor_precision=_beside(precision, self.jacobian))


def evidence_of(
    robot: str, kind: str, day: str, segments: Segments, crossings: Crossings, roughness: float
) -> Evidence:
    """Return the evidence of a recording on a floor of a roughness [m/sqrt(m)]."""
    precision = np.linalg.inv(segments.covariance(roughness))
    precision = 0.5 * (precision + precision.T)
    jacobian = segments.jacobian.reshape(-1, 3)
    beside = _beside(precision, jacobian)
    return Evidence(robot, kind, day, segments.residual.reshape(-1), jacobian, precision, beside, crossings)


def _beside(precision: Array, jacobian: Array) -> Array:
    """Return what of a precision is left beside any parameters of the robot."""
    weighed = precision @ jacobian
    return np.asarray(precision - weighed @ np.linalg.pinv(jacobian.T @ weighed) @ weighed.T, np.float64)


class AllCrossings:
    """The crossings of many recordings together, in which those near a place are found at once.

    Attributes:
        sure: Evidence of the recordings.
        evidence: The same with the errors besides that `doubt` states.
        effects: What places of unit size make of their residuals, by effect, x, y and reach, as they are
            asked for.
    """

    def __init__(self, evidence: Sequence[Evidence]) -> None:
        self.evidence = self.sure = evidence
        self.effects: dict[tuple[str, float, float, float], Effects] = {}
        counts = [len(single.crossings.way) for single in evidence]
        self._owner = np.repeat(np.arange(len(evidence)), counts)
        self._first = np.cumsum([0, *counts])
        self._cell = np.concatenate([single.crossings.cell for single in evidence]).astype(np.int32)

    def doubt(self, errors: Mapping[int, Array]) -> None:
        """State independent errors besides, `(3 S, K)` by recording, instead of those stated before."""
        self.evidence = [
            single.less_sure([errors[number]]) if number in errors else single
            for number, single in enumerate(self.sure)
        ]

    def near(self, x: float, y: float, reach: float) -> Iterator[tuple[int, NDArray[np.int64]]]:
        """Yield recordings that come nearer to a place than a reach [m], and the rows of their crossings."""
        low = np.floor((np.array([x, y]) - reach) / CELL)
        high = np.ceil((np.array([x, y]) + reach) / CELL)
        along, across = self._cell[:, 0], self._cell[:, 1]
        inside = (along >= low[0]) & (along <= high[0])
        inside &= (across >= low[1]) & (across <= high[1])
        rows = np.flatnonzero(inside)
        if not len(rows):
            return
        owners, first = np.unique(self._owner[rows], return_index=True)
        for owner, part in zip(owners.tolist(), np.split(rows, first[1:]), strict=True):
            yield owner, part - self._first[owner]
