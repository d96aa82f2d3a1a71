"""The records that the runner's compiled functions share: fixed settings, and what changes per sample."""

from typing import Annotated

from vehicle.compiled import Array


class Settings:
    """What does not change during a program.

    Attributes:
        trucks: 1 or 2.
        parallel: 1 where truck b keeps the formation, 0 where it follows like a car's rear axle.
        period: between two steps [s].
        speed: limit of every wheel over the floor [m/s].
        acceleration: limit likewise [m/s^2].
        wheelbase: of each truck [m].
        radius: of each wheel [m].
        tolerance: to which a truck's travel is driven [m]: what its encoders resolve.
        turn_tolerance: to which its heading is driven [rad].
        link_length: that truck b keeps [m].
    """

    trucks: int
    parallel: int
    period: float
    speed: float
    acceleration: float
    wheelbase: Annotated[Array, 2]
    radius: Annotated[Array, 4]
    tolerance: Annotated[Array, 2]
    turn_tolerance: Annotated[Array, 2]
    link_length: float


class State:
    """Where the runner is in its program.

    Attributes:
        row: of the program; the number of rows when it is done.
        entered: 0 before the first step.
        phase: of a drive home.
        rested: steps since standstill in this row.
        lap: of the row; -1 between laps.
        fix_due: 1 in the one step in which an absolute fix is due.
        at_rest: 1 while every commanded speed is, and was a step before, zero.
        heading: of truck a, unwrapped [rad].
        frame: pose in which the rows are given, heading unwrapped.
        formation: heading of the link that truck b keeps [rad].
        bearing: around an arc's centre at the last step [rad].
        progress: along an arc [m].
        course: of the line to the goal [rad].
        backwards: 1 where that line is driven in reverse.
        pose: of the two trucks, as odometry and the linkage tell.
        link: joint_a [rad], joint_b [rad], length [m].
        speeds: last commanded speed of each wheel over the floor [m/s].
    """

    row: int
    entered: int
    phase: int
    rested: int
    lap: int
    fix_due: int
    at_rest: int
    heading: float
    frame: Annotated[Array, 3]
    formation: float
    bearing: float
    progress: float
    course: float
    backwards: int
    pose: Annotated[Array, (2, 3)]
    link: Annotated[Array, 3]
    speeds: Annotated[Array, 4]
