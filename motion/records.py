"""The records that the runner's compiled functions share: fixed settings, and what changes per sample."""

from typing import Annotated

from omnimate.vehicle.compiled import Array


class Settings:
    """Constants of a program on a vehicle.

    Attributes:
        trucks: Number of trucks, 1 or 2.
        parallel: 1 where truck b keeps the formation, 0 where it follows like a car's rear axle.
        period: Time between two steps [s].
        speed: Speed limit of every wheel over the floor [m/s].
        acceleration: Acceleration limit of every wheel over the floor [m/s^2].
        wheelbase: Wheelbase of each truck [m].
        radius: Radius of each wheel [m].
        tolerance: Accuracy of each truck's travel [m]: the resolution of its encoders.
        turn_tolerance: Accuracy to which each truck's heading is driven [rad].
        link_length: Length of the link that truck b keeps [m].
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
    """State of the runner in its program.

    Attributes:
        row: Current row of the program; the number of rows when it is done.
        entered: 0 before the first step, then 1.
        phase: Phase of a drive to a goal.
        rested: Number of steps since standstill in this row.
        lap: Lap of the current row; -1 between laps.
        fix_due: 1 in the one step in which an absolute fix is due.
        at_rest: 1 while every commanded speed is, and was a step before, zero.
        heading: Heading of truck a, unwrapped [rad].
        frame: Pose in whose frame the rows are given, heading unwrapped.
        formation: Heading of the link that truck b keeps [rad].
        bearing: Bearing from an arc's centre at the last step [rad].
        progress: Distance driven along an arc [m].
        course: Course of the line to the goal [rad].
        backwards: 1 where that line is driven in reverse.
        pose: Poses of the two trucks by odometry and the linkage.
        link: Reading of the linkage: joint_a [rad], joint_b [rad], length [m].
        speeds: Last commanded speed of each wheel over the floor [m/s].
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
