"""The bodies of answers about UMBmark sessions. All values are in SI units; times are seconds since 1970."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, Field

from omnimate.service.umbmark.fields import Call, Direction, How, Method, Severity, State
from omnimate.vehicle.parameters import TruckName


class ReturnError(BaseModel):
    """The return error of a run: absolute minus calculated pose, U (3.1), in the frame of its start."""

    x: float
    y: float
    theta: float | None


class Sample(BaseModel):
    """One run of a session."""

    number: int
    direction: Direction
    created: float
    errors: dict[TruckName, ReturnError]
    source: str
    recording: str | None


class Counts(BaseModel):
    """The number of runs in each direction."""

    cw: int
    ccw: int


class Session(BaseModel):
    """A UMBmark session. Lists of sessions leave out the samples."""

    id: str
    vehicle: str
    vehicle_version: int
    side: float
    runs: int
    how: How
    state: State
    detail: str
    possible: list[Call]
    created: float
    changed: float
    expires: float
    counts: Counts
    samples: list[Sample] | None = None


class Limits(BaseModel):
    """A value and its 95 % confidence interval, which is null when there are too few runs."""

    value: float
    low: float | None
    high: float | None


class MethodResult(BaseModel):
    """The calibration of a truck by one method."""

    method: Method
    e_b: Limits
    e_d: Limits
    c_left: float
    c_right: float
    wheelbase: Limits
    diameter_left: Limits
    diameter_right: Limits
    after: Annotated[
        float, Field(description="The error E_max,syst that remains after this calibration [m].")
    ]


class Errors(BaseModel):
    """The return errors of all runs in summary, U (3.2) to (3.4) [m]."""

    e_max_syst: float
    after: float
    centres: dict[Direction, ReturnError]
    scatter: float | None
    sem: float | None


class Advice(BaseModel):
    """The finding of a check of the runs: what is wrong, and what to do about it."""

    severity: Severity
    what: str
    do: str


class TruckSizes(BaseModel):
    """The wheelbase and the wheel diameters of a truck [m]."""

    wheelbase: float
    wheel_diameter_left: float
    wheel_diameter_right: float


class TruckResult(BaseModel):
    """The calibration of one truck."""

    errors: Errors
    methods: list[MethodResult]
    advice: list[Advice]
    second_pass: str
    nominal: TruckSizes
    calibrated: TruckSizes


class Result(BaseModel):
    """The result of a session."""

    session: str
    revision: Annotated[str, Field(description="The revision of the result, which is also its ETag.")]
    vehicle: str
    vehicle_version: int
    method: Method
    trucks: dict[TruckName, TruckResult]
    usable: bool
