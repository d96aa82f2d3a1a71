"""The stretches of a drive in which wheels lost travel, as the filter reports them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.vehicle.parameters import WHEELS

if TYPE_CHECKING:
    from omnimate.vehicle.compiled import Array
    from omnimate.vehicle.parameters import Channel

NOTABLE = 7e-4  # [m] lost travel from which on a disturbance is reported; false alarms make 0.2 mm


@dataclass(frozen=True, slots=True)
class Disturbance:
    """A stretch in which a wheel did not travel as far as it rolled, because of a bump or of slip.

    Attributes:
        wheel: Channel of the wheel.
        start: Time at which the disturbance was noticed, on the recording's clock [s].
        end: Time of the last sample in which the wheel was distrusted, on the recording's clock [s].
        lost: Travel that the wheel lost [m].
    """

    wheel: Channel
    start: float
    end: float
    lost: float


def find_disturbances(time: Array, alert: Array, lost: Array) -> tuple[Disturbance, ...]:
    """Return the stretches in which wheels were distrusted and lost `NOTABLE` or more, in order of time.

    Args:
        time: Time of each sample [s], shape `(N,)`.
        alert: Travel for which each wheel stays distrusted after each sample [m], shape `(N, 4)`.
        lost: Travel that each wheel lost in each sample [m], shape `(N, 4)`.
    """
    disturbances = []
    for number, wheel in enumerate(WHEELS):
        marks = np.diff(np.concatenate(([0], alert[:, number] > 0.0, [0])).astype(np.int8))
        starts, ends = np.flatnonzero(marks > 0).tolist(), (np.flatnonzero(marks < 0) - 1).tolist()
        for first, last in zip(starts, ends, strict=True):
            total = float(lost[first : last + 1, number].sum())
            if total >= NOTABLE:
                disturbances.append(Disturbance(wheel, float(time[first]), float(time[last]), total))
    return tuple(sorted(disturbances, key=lambda disturbance: disturbance.start))
