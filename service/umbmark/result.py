"""From the runs of a session to its result: every method side by side, the guards' advice, the figure."""

from __future__ import annotations

import hashlib
import math
from dataclasses import asdict
from typing import TYPE_CHECKING, get_args

import numpy as np

from calib.apply import corrected_vehicle
from calib.errors import CalibrationError
from calib.experiment import Calibration, Experiment, calibrate, usable_methods
from calib.guards import advise
from calib.return_errors import ReturnErrors
from calib.stop_rule import stop_rule
from calib.uncertainty import uncertainty_of
from service.errors import StateError, ValueProblem
from service.umbmark.models import (
    Advice,
    Errors,
    Limits,
    MethodResult,
    Result,
    ReturnError,
    TruckResult,
    TruckSizes,
    Turn,
)
from vehicle.parameters import TRUCKS, Truck

if TYPE_CHECKING:
    from collections.abc import Sequence

    from calib.umbmark import Method
    from calib.uncertainty import Interval
    from figures.plots import Clusters
    from service.store.tables import SessionRow
    from service.umbmark.models import Sample
    from vehicle.parameters import TruckName, VehicleParameters
    from vehicle.se2 import Array

TURNS: tuple[Turn, ...] = get_args(Turn)


def result_of(
    row: SessionRow, samples: Sequence[Sample], vehicle: VehicleParameters, method: Method
) -> Result:
    """Return what the runs of a session make of its vehicle.

    Raises:
        StateError: no truck has runs in both directions.
        ValueProblem: the data do not allow the method.
    """
    experiments = experiments_of(row, samples, vehicle)
    found = {name: _truck(one, method) for name, one in experiments.items()}
    usable = not any(advice.severity == "error" for one in found.values() for advice in one.advice)
    result = Result(
        session=row.id,
        revision="",
        vehicle=row.vehicle,
        vehicle_version=row.vehicle_version,
        method=method,
        trucks=found,
        usable=usable,
    )
    digest = hashlib.sha256(result.model_dump_json().encode()).hexdigest()[:16]
    return result.model_copy(update={"revision": digest})


def experiments_of(
    row: SessionRow, samples: Sequence[Sample], vehicle: VehicleParameters
) -> dict[TruckName, Experiment]:
    """Return the experiment of every truck that was driven in both directions.

    Raises:
        StateError: no truck was.
    """
    experiments = {}
    for name, truck in vehicle.trucks.items():
        cw, ccw = (_errors(samples, name, turn) for turn in TURNS)
        if len(cw) and len(ccw):
            errors = ReturnErrors(cw, ccw, row.side, f"session {row.id}, truck {name}")
            experiments[name] = Experiment(errors.source, truck, errors)
    if not experiments:
        count = {turn: sum(one.direction == turn for one in samples) for turn in TURNS}
        raise StateError(
            f"{count['cw']} run(s) cw and {count['ccw']} ccw; one direction alone cannot tell the wheelbase "
            "from the diameters: drive the square in both, five times each",
        )
    return experiments


def _errors(samples: Sequence[Sample], truck: TruckName, turn: Turn) -> Array:
    rows = [
        (error.x, error.y, math.nan if error.theta is None else error.theta)
        for one in samples
        if one.direction == turn and (error := one.errors.get(truck)) is not None
    ]
    return np.array(rows, np.float64).reshape(-1, 3)


def _truck(experiment: Experiment, method: Method) -> TruckResult:
    errors = experiment.errors
    try:
        found = {one: calibrate(experiment, one) for one in usable_methods(errors)}
        advice = advise(experiment)
    except CalibrationError as error:
        raise ValueProblem("samples", str(error)) from error
    if method not in found:
        raise ValueProblem("method", f"{method} needs the heading of every run, and three runs or more")
    chosen = found[method]
    centres = {turn: _error(centre) for turn, centre in zip(TURNS, errors.centres, strict=True)}
    return TruckResult(
        errors=Errors(
            e_max_syst=errors.e_max_syst,
            after=chosen.errors.e_max_syst,
            centres=centres,
            scatter=_known(errors.scatter),
            sem=_known(errors.sem),
        ),
        methods=[_method(one) for one in found.values()],
        advice=[Advice(severity=one.severity, what=one.what, do=one.do) for one in advice],
        second_pass=stop_rule(errors),
        nominal=TruckSizes(**asdict(experiment.truck)),
        calibrated=TruckSizes(**asdict(chosen.truck)),
    )


def _method(calibration: Calibration) -> MethodResult:
    known = uncertainty_of(calibration)
    return MethodResult(
        method=calibration.correction.method,
        e_b=_limits(known.e_b),
        e_d=_limits(known.e_d),
        c_left=calibration.c_left,
        c_right=calibration.c_right,
        wheelbase=_limits(known.wheelbase),
        diameter_left=_limits(known.diameter_left),
        diameter_right=_limits(known.diameter_right),
        after=calibration.errors.e_max_syst,
    )


def _limits(interval: Interval) -> Limits:
    return Limits(value=interval.value, low=_known(interval.low), high=_known(interval.high))


def _error(pose: Array) -> ReturnError:
    return ReturnError(x=float(pose[0]), y=float(pose[1]), theta=_known(float(pose[2])))


def _known(value: float) -> float | None:
    return value if math.isfinite(value) else None


def calibrated_vehicle(vehicle: VehicleParameters, result: Result) -> VehicleParameters:
    """Return the vehicle with the trucks that a result calibrated."""
    trucks = {name: Truck(**one.calibrated.model_dump()) for name, one in result.trucks.items()}
    return corrected_vehicle(vehicle, trucks)


def panels(experiments: dict[TruckName, Experiment], result: Result) -> list[Clusters]:
    """Return what the figure of a result shows: one panel for each truck."""
    from figures.plots import Clusters

    found: list[Clusters] = []
    for name in TRUCKS:
        if name in experiments and name in result.trucks:
            calibration = calibrate(experiments[name], result.method)
            found.append(Clusters(f"truck {name}", experiments[name].errors, calibration.errors))
    return found
