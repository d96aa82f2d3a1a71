"""The runs of a session as the experiments that calibration works with, one for each truck."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, get_args

import numpy as np

from omnimate.calib.umbmark.experiment import Experiment
from omnimate.calib.umbmark.return_errors import ReturnErrors
from omnimate.service.errors import StateError
from omnimate.service.umbmark.fields import Direction

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.service.store.tables import SessionRow
    from omnimate.service.umbmark.responses import Sample
    from omnimate.vehicle.parameters import TruckName, VehicleParameters
    from omnimate.vehicle.se2 import Array

DIRECTIONS: tuple[Direction, ...] = get_args(Direction)


def experiments_of(
    row: SessionRow, samples: Sequence[Sample], vehicle: VehicleParameters
) -> dict[TruckName, Experiment]:
    """Return the experiment of every truck that has runs in both directions.

    Raises:
        StateError: no truck has runs in both directions.
    """
    experiments = {}
    for name, truck in vehicle.trucks.items():
        cw, ccw = (_return_errors(samples, name, direction) for direction in DIRECTIONS)
        if len(cw) and len(ccw):
            errors = ReturnErrors(cw, ccw, row.side, f"session {row.id}, truck {name}")
            experiments[name] = Experiment(errors.source, truck, errors)
    if not experiments:
        counts = {turn: sum(sample.direction == turn for sample in samples) for turn in DIRECTIONS}
        raise StateError(
            f"{counts['cw']} run(s) cw and {counts['ccw']} ccw; one direction alone cannot separate the "
            "wheelbase from the diameters: drive the square in both directions, five times each",
        )
    return experiments


def _return_errors(samples: Sequence[Sample], truck: TruckName, direction: Direction) -> Array:
    """Return the return errors `(N, 3)` of a truck in one direction; theta is nan where unknown."""
    rows = [
        (error.x, error.y, math.nan if error.theta is None else error.theta)
        for sample in samples
        if sample.direction == direction and (error := sample.errors.get(truck)) is not None
    ]
    return np.array(rows, np.float64).reshape(-1, 3)
