"""The filter's estimate after a sample, for reading."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.ipec.filter.poses import look
from omnimate.ipec.filter.slow_parameters import SlowParameters, slow_parameters

if TYPE_CHECKING:
    from omnimate.vehicle.compiled import Array, Record
    from omnimate.vehicle.parameters import TruckName


@dataclass(frozen=True, slots=True)
class FilteredState:
    """The estimate after a sample. It is never changed: each step returns another one.

    Attributes:
        record: The estimate as one read-only record `(1,)` of `omnimate.ipec.filter.records.FilterState`.
        filters: The open filters as read-only records `(H,)` of `omnimate.ipec.filter.records.OpenFilter`;
            states between which no step has ended share them.
    """

    record: Record
    filters: Record

    def pose(self, truck: TruckName = "a") -> Array:
        """Return the pose x, y, heading of a truck [m, m, rad], shape `(3,)`.

        The pose of truck b is nan until the linkage has been read.
        """
        return self._look(truck)[0]

    def sigma(self, truck: TruckName = "a") -> Array:
        """Return the standard deviations of a truck's pose [m, m, rad], shape `(3,)`."""
        return self._look(truck)[1]

    def _look(self, truck: TruckName) -> tuple[Array, Array]:
        pose, sigma = np.empty(3), np.empty(3)
        state = self.record[0]
        look(state["mean"], state["known"], 0 if truck == "a" else 1, pose, sigma)
        if truck == "b" and not state["placed"]:
            pose[:], sigma[:] = np.nan, np.nan
        return pose, sigma

    @property
    def _likely(self) -> np.void:
        """The open filter of the most probable hypothesis."""
        likely: np.void = self.filters[self.record["weight"][0].argmax()]
        return likely

    @property
    def _ended(self) -> bool:
        """Whether the last sample has ended a step."""
        return bool(self.record["predicted"][0])

    @property
    def nis(self) -> float:
        """Normalised innovation squared of the last sample, 3 degrees of freedom; nan without one."""
        return float(self._likely["nis"]) if self._ended else math.nan

    @property
    def disturbed(self) -> tuple[bool, ...]:
        """Whether each wheel is distrusted, in the order of `WHEELS`."""
        return tuple((self._likely["alert"][:4] > 0.0).tolist())

    @property
    def lost(self) -> tuple[float, ...]:
        """Travel that each distrusted wheel lost in the last sample [m], in the order of `WHEELS`."""
        return tuple(self._likely["lost"].tolist()) if self._ended else (0.0,) * 4

    @property
    def slow(self) -> SlowParameters:
        """The estimated systematic errors of the encoders and their standard deviations."""
        return slow_parameters(self.record["mean"][0], self.record["known"][0])
