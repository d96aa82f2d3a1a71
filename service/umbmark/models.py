"""The bodies of requests and answers about UMBmark sessions, in SI units; times are seconds since 1970."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, Discriminator, Field, Tag, model_validator

from omnimate.vehicle.parameters import TruckName

How = Literal["manual", "recordings", "drive"]
Direction = Literal["cw", "ccw"]
Method = Literal["printed-x", "printed-y", "printed", "printed-true-b", "heading", "exact", "weighted"]
Severity = Literal["note", "warning", "error"]
State = Literal[
    "collecting", "driving", "measuring", "interrupted", "solved", "accepted", "aborted", "failed", "expired"
]
Call = Literal["sample", "remove", "solve", "accept", "resume", "abort"]

Metre = Annotated[float, Field(ge=-1000.0, le=1000.0, description="[m]")]
Range = Annotated[float, Field(gt=0.0, le=100.0, description="[m]")]
Radian = Annotated[float, Field(ge=-math.tau, le=math.tau, description="[rad], counter-clockwise")]
NAME_PATTERN = r"^[^\x00-\x1f/\\]{1,100}$"
Name = Annotated[str, Field(min_length=1, max_length=100, pattern=NAME_PATTERN)]
FiniteOrNull = Annotated[
    float | None, BeforeValidator(lambda value: value if value is not None and math.isfinite(value) else None)
]  # nan becomes null
Id = Annotated[str, Field(min_length=1, max_length=32, pattern=r"^[0-9a-z]+$")]


class RequestModel(BaseModel):
    """The body of a request; refused are unknown fields, values of another type, and infinite numbers."""

    model_config = ConfigDict(extra="forbid", strict=True, str_strip_whitespace=True, allow_inf_nan=False)


class RowModel(BaseModel):
    """An answer whose fields are columns of a table, or attributes of a dataclass."""

    @classmethod
    def of(cls, row: object, **others: object) -> Self:
        """Return the answer that shows a row; `others` are fields that it lacks, or that differ."""
        if not others:
            return cls.model_validate(row, from_attributes=True)
        shown = {name: getattr(row, name) for name in cls.model_fields if hasattr(row, name)}
        return cls.model_validate(shown | others, from_attributes=True)


class Geometry(RequestModel):
    """The positions of the three range sensors on the truck and of the two walls (U section V)."""

    baseline: Range = Field(
        default=0.405, description="The distance between the two sensors on the right side [m]."
    )
    side: Metre = Field(
        default=0.3, description="The distance of these two sensors from the truck's middle line [m]."
    )
    rear: Metre = Field(default=0.3, description="The distance of the rear sensor behind the drive axle [m].")
    wall_x: Metre = Field(default=-2.5, description="The x coordinate of the short wall [m].")
    wall_y: Metre = Field(default=-6.0, description="The y coordinate of the long wall [m].")


class Walls(RequestModel):
    """Three distances to an L-shaped corner of walls, each measured perpendicular to its wall."""

    right_front: Range
    right_rear: Range
    behind: Range
    geometry: Geometry = Geometry()


class Coordinates(RequestModel):
    """An absolute pose. The heading `theta` may be left out when it was not measured."""

    x: Metre
    y: Metre
    theta: Radian | None = None


class ByWalls(RequestModel):
    """An absolute pose, given by the distances to the walls from which it is calculated."""

    walls: Walls


def _by_field(name: str, having: type[BaseModel], other: type[BaseModel]) -> Discriminator:
    """Return what chooses between two forms of a body by a field, so that errors are those of one form."""

    def form(given: object) -> str:
        has = isinstance(given, having) or (isinstance(given, dict) and name in given)
        return having.__name__ if has else other.__name__

    return Discriminator(form)


Fix = Annotated[
    Annotated[Coordinates, Tag("Coordinates")] | Annotated[ByWalls, Tag("ByWalls")],
    _by_field("walls", ByWalls, Coordinates),
]


class SessionStart(RequestModel):
    """The square that is going to be driven, and how its runs are measured."""

    vehicle: Name | None = Field(
        default=None, description="The name of the vehicle. Default: the vehicle on the service's bus."
    )
    side: float = Field(default=4.0, ge=0.2, le=100.0, description="The side of the square [m].")
    runs: int = Field(
        default=5, ge=1, le=50, description="The number of runs that are wanted in each direction."
    )
    how: How = "manual"
    speed: float = Field(
        default=0.4,
        ge=0.02,
        le=2.0,
        description="The speed of the wheels when the service drives the robot [m/s].",
    )
    lifeline: float | None = Field(
        default=30.0,
        ge=1.0,
        le=3600.0,
        description="When the service drives the robot: it stops when no client has asked for the "
        "session for this time [s]. Null: it never stops for this reason.",
    )


class SampleOfFixes(RequestModel):
    """One run, given by its absolute poses and by the pose that odometry shows at its end."""

    direction: Direction | None = Field(
        default=None, description="The direction of the run. Default: that of the driven lap."
    )
    truck: TruckName = "a"
    before: Fix | None = Field(
        default=None, description="The pose before the run. Default: the origin with heading 0."
    )
    after: Fix
    calculated: Coordinates | None = Field(
        default=None,
        description="The pose that odometry shows at the end of a run that began at `before`. "
        "Default: that of the driven lap.",
    )


class SampleOfRecording(RequestModel):
    """All runs of an uploaded recording."""

    recording: Id


SampleGiven = Annotated[
    Annotated[SampleOfFixes, Tag("SampleOfFixes")] | Annotated[SampleOfRecording, Tag("SampleOfRecording")],
    _by_field("recording", SampleOfRecording, SampleOfFixes),
]


class Solve(RequestModel):
    """The method by which a session is solved."""

    method: Method = "exact"


class Accept(RequestModel):
    """Whether to accept a result although a check of it reports an error."""

    force: bool = False


class ReturnError(BaseModel):
    """The return error of a run: absolute minus calculated pose, U (3.1), in the frame of its start."""

    x: float
    y: float
    theta: FiniteOrNull

    @model_validator(mode="before")
    @classmethod
    def _of_array(cls, pose: Any) -> Any:  # noqa: ANN401  # an array `(3,)`, or what pydantic takes
        return dict(zip("xy", pose[:2], strict=True), theta=pose[2]) if isinstance(pose, np.ndarray) else pose


class Sample(RowModel):
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


class Session(RowModel):
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
    low: FiniteOrNull
    high: FiniteOrNull


class MethodResult(RowModel):
    """The calibration of a truck by one method."""

    method: Method
    e_b: Limits
    e_d: Limits
    c_left: float
    c_right: float
    wheelbase: Limits
    diameter_left: Limits
    diameter_right: Limits
    after: float = Field(description="The error E_max,syst that remains after this calibration [m].")


class Errors(RowModel):
    """The return errors of all runs in summary, U (3.2) to (3.4) [m]."""

    e_max_syst: float
    after: float
    centres: dict[Direction, ReturnError]
    scatter: FiniteOrNull
    sem: FiniteOrNull


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


class TruckResult(RowModel):
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
    revision: str = Field(description="The revision of the result, which is also its ETag.")
    vehicle: str
    vehicle_version: int
    method: Method
    trucks: dict[TruckName, TruckResult]
    usable: bool
