"""The records that the runner's compiled functions share: fixed settings, and what changes per sample."""

from typing import Annotated

from omnimate.vehicle.compiled import Array


class Settings:
    """Constants of a program on a vehicle."""

    trucks: int  # number of trucks, 1 or 2
    parallel: int  # 1 where truck b keeps the formation, 0 where it follows like a car's rear axle
    period: float  # time between two steps [s]
    speed: float  # speed limit of every wheel over the floor [m/s]
    acceleration: float  # acceleration limit of every wheel over the floor [m/s^2]
    wheelbase: Annotated[Array, 2]  # wheelbase of each truck [m]
    radius: Annotated[Array, 4]  # radius of each wheel [m]
    tolerance: Annotated[Array, 2]  # accuracy of each truck's travel [m]: the resolution of its encoders
    turn_tolerance: Annotated[Array, 2]  # accuracy to which each truck's heading is driven [rad]
    link_length: float  # length of the link that truck b keeps [m]


class State:
    """State of the runner in its program."""

    row: int  # current row of the program; the number of rows when it is done
    entered: int  # 0 before the first step, then 1
    phase: int  # phase of a drive to a goal
    rested: int  # number of steps since standstill in this row
    lap: int  # lap of the current row; -1 between laps
    fix_due: int  # 1 in the one step in which an absolute fix is due
    at_rest: int  # 1 while every commanded speed is, and was a step before, zero
    heading: float  # heading of truck a, unwrapped [rad]
    frame: Annotated[Array, 3]  # pose in whose frame the rows are given, heading unwrapped
    formation: float  # heading of the link that truck b keeps [rad]
    bearing: float  # bearing from an arc's centre at the last step [rad]
    progress: float  # distance driven along an arc [m]
    course: float  # course of the line to the goal [rad]
    backwards: int  # 1 where that line is driven in reverse
    pose: Annotated[Array, (2, 3)]  # poses of the two trucks by odometry and the linkage
    link: Annotated[Array, 3]  # reading of the linkage: joint_a [rad], joint_b [rad], length [m]
    speeds: Annotated[Array, 4]  # last commanded speed of each wheel over the floor [m/s]
