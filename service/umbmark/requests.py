"""The bodies of requests about UMBmark sessions."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from omnimate.service.umbmark.fields import (
    Direction,
    How,
    Id,
    Method,
    Metre,
    Name,
    Radian,
    Range,
    RequestModel,
)
from omnimate.vehicle.parameters import TruckName


class Geometry(RequestModel):
    """The positions of the three range sensors on the truck and of the two walls (U section V)."""

    baseline: Annotated[
        Range, Field(description="The distance between the two sensors on the right side [m].")
    ] = 0.405
    side: Annotated[
        Metre, Field(description="The distance of these two sensors from the truck's middle line [m].")
    ] = 0.3
    rear: Annotated[
        Metre, Field(description="The distance of the rear sensor behind the drive axle [m].")
    ] = 0.3
    wall_x: Annotated[Metre, Field(description="The x coordinate of the short wall [m].")] = -2.5
    wall_y: Annotated[Metre, Field(description="The y coordinate of the long wall [m].")] = -6.0


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


Fix = Coordinates | ByWalls


class SessionStart(RequestModel):
    """The square that is going to be driven, and how its runs are measured."""

    vehicle: Annotated[
        Name | None, Field(description="The name of the vehicle. Default: the vehicle on the service's bus.")
    ] = None
    side: Annotated[
        float, Field(ge=0.2, le=100.0, allow_inf_nan=False, description="The side of the square [m].")
    ] = 4.0
    runs: Annotated[
        int, Field(ge=1, le=50, description="The number of runs that are wanted in each direction.")
    ] = 5
    how: How = "manual"
    speed: Annotated[
        float,
        Field(
            ge=0.02,
            le=2.0,
            allow_inf_nan=False,
            description="The speed of the wheels when the service drives the robot [m/s].",
        ),
    ] = 0.4
    lifeline: Annotated[
        float | None,
        Field(
            ge=1.0,
            le=3600.0,
            allow_inf_nan=False,
            description="When the service drives the robot: it stops when no client has asked for the "
            "session for this time [s]. Null: it never stops for this reason.",
        ),
    ] = 30.0


class SampleOfFixes(RequestModel):
    """One run, given by its absolute poses and by the pose that odometry shows at its end."""

    direction: Annotated[
        Direction | None, Field(description="The direction of the run. Default: that of the driven lap.")
    ] = None
    truck: TruckName = "a"
    before: Annotated[
        Fix | None, Field(description="The pose before the run. Default: the origin with heading 0.")
    ] = None
    after: Fix
    calculated: Annotated[
        Coordinates | None,
        Field(
            description="The pose that odometry shows at the end of a run that began at `before`. "
            "Default: that of the driven lap."
        ),
    ] = None


class SampleOfRecording(RequestModel):
    """All runs of an uploaded recording."""

    recording: Id


SampleGiven = SampleOfFixes | SampleOfRecording


class Solve(RequestModel):
    """The method by which a session is solved."""

    method: Method = "exact"


class Accept(RequestModel):
    """Whether to accept a result although a check of it reports an error."""

    force: bool = False
