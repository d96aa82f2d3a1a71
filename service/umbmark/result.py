"""From the runs of a session to its result: all methods side by side, the checks' advice, the figure."""

from __future__ import annotations

import hashlib
import math
from dataclasses import asdict
from typing import TYPE_CHECKING, get_args

import numpy as np

from omnimate.calib.errors import CalibrationError, MethodError
from omnimate.calib.umbmark.assessment import Assessment, assess
from omnimate.calib.umbmark.experiment import Calibration, Experiment, calibrate
from omnimate.calib.umbmark.return_errors import ReturnErrors, stop_rule
from omnimate.calib.umbmark.uncertainty import uncertainty_of
from omnimate.service.errors import InvalidValueError, StateError
from omnimate.service.umbmark.models import (
    Advice,
    Direction,
    Errors,
    Limits,
    MethodResult,
    Result,
    ReturnError,
    TruckResult,
    TruckSizes,
)
from omnimate.vehicle.parameters import TRUCKS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.calib.umbmark.printed import Method
    from omnimate.calib.umbmark.uncertainty import Interval
    from omnimate.figures.clusters import Clusters
    from omnimate.service.store.tables import SessionRow
    from omnimate.service.umbmark.models import Sample
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


def make_result(
    row: SessionRow, samples: Sequence[Sample], vehicle: VehicleParameters, method: Method
) -> Result:
    """Return the calibration of a session's vehicle by its runs.

    Raises:
        StateError: no truck has runs in both directions.
        InvalidValueError: the data do not allow the method.
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
    centres = {
        direction: ReturnError.of(centre)
        for direction, centre in zip(DIRECTIONS, errors.centres, strict=True)
    }
    return TruckResult(
        errors=Errors(
            e_max_syst=errors.e_max_syst,
            after=chosen.errors.e_max_syst,
            centres=centres,
            scatter=_or_none(errors.scatter),
            sem=_or_none(errors.sem),
        ),
        methods=[_method(calibration) for calibration in assessment.calibrations],
        advice=[
            Advice(severity=advice.severity, what=advice.what, do=advice.do) for advice in assessment.advice
        ],
        second_pass=stop_rule(errors),
        nominal=TruckSizes(**asdict(experiment.truck)),
        calibrated=TruckSizes(**asdict(chosen.truck)),
    )


def _method(calibration: Calibration) -> MethodResult:
    intervals = uncertainty_of(calibration)
    return MethodResult(
        method=calibration.correction.method,
        e_b=_limits(intervals.e_b),
        e_d=_limits(intervals.e_d),
        c_left=calibration.c_left,
        c_right=calibration.c_right,
        wheelbase=_limits(intervals.wheelbase),
        diameter_left=_limits(intervals.diameter_left),
        diameter_right=_limits(intervals.diameter_right),
        after=calibration.errors.e_max_syst,
    )


def _limits(interval: Interval) -> Limits:
    return Limits(value=interval.value, low=_or_none(interval.low), high=_or_none(interval.high))


def _or_none(value: float) -> float | None:
    return value if math.isfinite(value) else None


def cluster_panels(experiments: dict[TruckName, Experiment], result: Result) -> list[Clusters]:
    """Return the panels of a result's figure, one for each truck."""
    from omnimate.figures.clusters import Clusters

    panels: list[Clusters] = []
    for name in TRUCKS:
        if name in experiments and name in result.trucks:
            calibration = calibrate(experiments[name], result.method)
            panels.append(Clusters(f"truck {name}", experiments[name].errors, calibration.errors))
    return panels
