"""From the runs of a session to its result: all methods side by side, the checks' advice, the figure."""

from __future__ import annotations

import hashlib
import math
from typing import TYPE_CHECKING, get_args

import numpy as np

from omnimate.calib.errors import CalibrationError, MethodError
from omnimate.calib.umbmark.assessment import Assessment, assess
from omnimate.calib.umbmark.experiment import Calibration, Experiment, calibrate
from omnimate.calib.umbmark.return_errors import ReturnErrors, stop_rule
from omnimate.calib.umbmark.uncertainty import uncertainty_of
from omnimate.service.errors import InvalidValueError
from omnimate.service.umbmark.models import Direction, Errors, MethodResult, Result, TruckResult
from omnimate.service.umbmark.sessions import refusal

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.calib.umbmark.printed import Method
    from omnimate.figures.clusters import Clusters
    from omnimate.service.store.tables import SampleRow, SessionRow
    from omnimate.vehicle.parameters import TruckName, VehicleParameters
    from omnimate.vehicle.se2 import Array

DIRECTIONS: tuple[Direction, ...] = get_args(Direction)


def experiments_of(
    row: SessionRow, samples: Sequence[SampleRow], vehicle: VehicleParameters
) -> dict[TruckName, Experiment]:
    """Return the experiment of every truck that has runs in both directions; StateError where none has."""
    experiments = {}
    for name, truck in vehicle.trucks.items():
        cw, ccw = (_return_errors(samples, name, direction) for direction in DIRECTIONS)
        if len(cw) and len(ccw):
            errors = ReturnErrors(cw, ccw, row.side, f"session {row.id}, truck {name}")
            experiments[name] = Experiment(errors.source, truck, errors)
    if not experiments:
        counts = {turn: sum(sample.direction == turn for sample in samples) for turn in DIRECTIONS}
        raise refusal(
            row,
            f"{counts['cw']} run(s) cw and {counts['ccw']} ccw; one direction alone cannot separate the "
            "wheelbase from the diameters: drive the square in both directions, five times each",
        )
    return experiments


def _return_errors(samples: Sequence[SampleRow], truck: TruckName, direction: Direction) -> Array:
    """Return the return errors `(N, 3)` of a truck in one direction; theta is nan where unknown."""
    rows = [
        (error.x, error.y, math.nan if error.theta is None else error.theta)
        for sample in samples
        if sample.direction == direction and (error := sample.errors.get(truck)) is not None
    ]
    return np.array(rows, np.float64).reshape(-1, 3)


def make_result(
    row: SessionRow, samples: Sequence[SampleRow], vehicle: VehicleParameters, method: Method
) -> Result:
    """Return the calibration of a session's vehicle by its runs.

    Raises as `experiments_of`, and InvalidValueError where the data do not allow the method.
    """
    experiments = experiments_of(row, samples, vehicle)
    try:
        assessments = {name: assess(experiment, (), name) for name, experiment in experiments.items()}
        trucks = {name: _truck(assessment, method) for name, assessment in assessments.items()}
    except MethodError as error:
        raise InvalidValueError("method", error.problem) from error
    except CalibrationError as error:
        raise InvalidValueError("samples", str(error)) from error
    result = Result(
        session=row.id,
        revision="",
        vehicle=row.vehicle,
        vehicle_version=row.vehicle_version,
        method=method,
        trucks=trucks,
        usable=all(assessment.is_usable for assessment in assessments.values()),
    )
    digest = hashlib.sha256(result.model_dump_json().encode()).hexdigest()[:16]
    return result.model_copy(update={"revision": digest})


def _truck(assessment: Assessment, method: Method) -> TruckResult:
    experiment, errors = assessment.experiment, assessment.experiment.errors
    chosen = assessment.by(method)
    after, centres = chosen.errors.e_max_syst, dict(zip(DIRECTIONS, errors.centres, strict=True))
    return TruckResult.of(
        assessment,
        errors=Errors.of(errors, after=after, centres=centres),
        methods=[_method(calibration) for calibration in assessment.calibrations],
        second_pass=stop_rule(errors),
        nominal=experiment.truck,
        calibrated=chosen.truck,
    )


def _method(calibration: Calibration) -> MethodResult:
    return MethodResult.of(
        uncertainty_of(calibration),
        method=calibration.correction.method,
        c_left=calibration.factors.c_left,
        c_right=calibration.factors.c_right,
        after=calibration.errors.e_max_syst,
    )


def cluster_panels(experiments: dict[TruckName, Experiment], method: Method) -> list[Clusters]:
    """Return the panels of a figure of the calibration by a method, one for each truck."""
    from omnimate.figures.clusters import Clusters

    return [
        Clusters(f"truck {name}", experiment.errors, calibrate(experiment, method).errors)
        for name, experiment in experiments.items()
    ]
