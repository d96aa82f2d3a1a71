"""What a client sends and gets of a UMBmark session. SI units; every number is finite and has bounds."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from vehicle.parameters import TruckName

How = Literal["manual", "recordings", "drive"]
Turn = Literal["cw", "ccw"]
Method = Literal["printed-x", "printed-y", "printed", "printed-true-b", "heading", "exact", "weighted"]
Severity = Literal["note", "warning", "error"]
State = Literal[
    "collecting", "driving", "measuring", "interrupted", "solved", "accepted", "aborted", "failed", "expired"
]
Call = Literal["sample", "remove", "solve", "accept", "resume", "abort"]

Metre = Annotated[float, Field(ge=-1000.0, le=1000.0, allow_inf_nan=False, description="[m]")]
Range = Annotated[float, Field(gt=0.0, le=100.0, allow_inf_nan=False, description="[m]")]
Radian = Annotated[
    float,
    Field(ge=-2.0 * math.pi, le=2.0 * math.pi, allow_inf_nan=False, description="[rad], counter-clockwise"),
]
NAME = r"^[^\x00-\x1f/\\]{1,100}$"
Name = Annotated[str, Field(min_length=1, max_length=100, pattern=NAME)]
Id = Annotated[str, Field(min_length=1, max_length=32, pattern=r"^[0-9a-z]+$")]


class Sent(BaseModel):
    """What is sent: nothing beyond the fields that are known."""

    model_config = ConfigDict(extra="forbid", str_strip_whitespace=True)


class Geometry(Sent):
    """Where the three range sensors and the walls are, U section V."""

    baseline: Annotated[Range, Field(description="between the two sensors on the right [m]")] = 0.405
    side: Annotated[Metre, Field(description="of these from the middle line [m]")] = 0.3
    rear: Annotated[Metre, Field(description="of the sensor behind from the drive axle [m]")] = 0.3
    wall_x: Annotated[Metre, Field(description="where the short wall stands [m]")] = -2.5
    wall_y: Annotated[Metre, Field(description="where the long wall stands [m]")] = -6.0


class Walls(Sent):
    """Three distances to an L-shaped corner of walls, perpendicular to them."""

    right_front: Range
    right_rear: Range
    behind: Range
    geometry: Geometry = Geometry()


class Coordinates(Sent):
    """An absolute pose; theta may be left out."""

    x: Metre
    y: Metre
    theta: Radian | None = None


class ByWalls(Sent):
    """An absolute pose by the distances from which it follows."""

    walls: Walls


Fix = Coordinates | ByWalls


class SessionStart(Sent):
    """What is going to be driven."""

    vehicle: Annotated[Name | None, Field(description="its name; left out: the one on the bus")] = None
    side: Annotated[float, Field(ge=0.2, le=100.0, allow_inf_nan=False, description="of the square [m]")] = (
        4.0
    )
    runs: Annotated[int, Field(ge=1, le=50, description="squares in each direction")] = 5
    how: How = "manual"
    speed: Annotated[
        float, Field(ge=0.02, le=2.0, allow_inf_nan=False, description="of the wheels, with drive [m/s]")
    ] = 0.4
    lifeline: Annotated[
        float | None,
        Field(
            ge=1.0,
            le=3600.0,
            allow_inf_nan=False,
            description="with drive: stop when no client asked for the session for so long [s]; null: never",
        ),
    ] = 30.0


class SampleOfFixes(Sent):
    """One run by its absolute fixes and where odometry ends."""

    direction: Annotated[Turn | None, Field(description="left out: that of the lap that was driven")] = None
    truck: TruckName = "a"
    before: Annotated[Fix | None, Field(description="left out: the origin, heading 0")] = None
    after: Fix
    calculated: Annotated[
        Coordinates | None,
        Field(description="where odometry ends, having begun at `before`; left out: as the lap was driven"),
    ] = None


class SampleOfRecording(Sent):
    """All runs of an uploaded recording."""

    recording: Id


SampleGiven = SampleOfFixes | SampleOfRecording


class Solve(Sent):
    """How to solve."""

    method: Method = "exact"


class Accept(Sent):
    """Whether to take a result that a guard advises against."""

    force: bool = False


class ReturnError(BaseModel):
    """Absolute minus calculated, U (3.1), in the frame of the start."""

    x: float
    y: float
    theta: float | None


class Sample(BaseModel):
    """One run."""

    number: int
    direction: Turn
    created: float
    errors: dict[TruckName, ReturnError]
    source: str
    recording: str | None


class Counts(BaseModel):
    """Runs in each direction."""

    cw: int
    ccw: int


class Session(BaseModel):
    """A session; without its samples in lists."""

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
    """A value and its 95 % interval; null where the runs are too few to tell."""

    value: float
    low: float | None
    high: float | None


class MethodResult(BaseModel):
    """What one method makes of the runs."""

    method: Method
    e_b: Limits
    e_d: Limits
    c_left: float
    c_right: float
    wheelbase: Limits
    diameter_left: Limits
    diameter_right: Limits
    after: Annotated[float, Field(description="E_max,syst that it leaves [m]")]


class Errors(BaseModel):
    """The return errors in sum, U (3.2)-(3.4) [m]."""

    e_max_syst: float
    after: float
    centres: dict[Turn, ReturnError]
    scatter: float | None
    sem: float | None


class Advice(BaseModel):
    """What a guard says."""

    severity: Severity
    what: str
    do: str


class TruckSizes(BaseModel):
    """Of one truck [m]."""

    wheelbase: float
    wheel_diameter_left: float
    wheel_diameter_right: float


class TruckResult(BaseModel):
    """Of one truck."""

    errors: Errors
    methods: list[MethodResult]
    advice: list[Advice]
    second_pass: str
    nominal: TruckSizes
    calibrated: TruckSizes


class Result(BaseModel):
    """Of a session."""

    session: str
    revision: Annotated[str, Field(description="of the result; its ETag")]
    vehicle: str
    vehicle_version: int
    method: Method
    trucks: dict[TruckName, TruckResult]
    usable: bool
