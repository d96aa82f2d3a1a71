"""One step of the simulated robot: its physics from wheel speeds to counts, stage by stage.

drive -> encoder -> ground travel -> body -> linkage -> bus: each stage is one function that changes the
state. Wheels are in the order of `WHEELS`, counts in that of `CHANNELS`.
"""

import math

from omnimate.vcan_sim.noise import FLOOR, STREAMS, normal_pair
from omnimate.vcan_sim.records import Constants, Obstacle, State
from omnimate.vehicle.arcs import glide as glide_pose
from omnimate.vehicle.arcs import roll as roll_pose
from omnimate.vehicle.compiled import Array, Record, compiled
from omnimate.vehicle.linkage import link_heading
from omnimate.vehicle.se2 import transform_xy, wrap_angle


@compiled
def drive(constants: Constants, state: State, command: Array, period: float) -> None:
    """Turn the wheels: ideal servos follow the commanded speeds [rad/s] with limited acceleration."""
    for wheel in range(2 * constants.trucks):
        max_change = constants.servo[wheel] * period
        state.speed[wheel] += min(max(command[wheel] - state.speed[wheel], -max_change), max_change)
        state.turned[wheel] = state.speed[wheel] * period
        state.angle[wheel] += state.turned[wheel]


@compiled
def read_wheels(constants: Constants, state: State) -> None:
    """Set the counts of the wheels: an incremental encoder rounds its angle down."""
    for wheel in range(2 * constants.trucks):
        state.counts[wheel] = math.floor(
            constants.offset[wheel] + constants.scale[wheel] * state.angle[wheel]
        )


@compiled
def roll(constants: Constants, state: State) -> None:
    """Set the travel of the wheels over the ground from their rotation and true radii."""
    for wheel in range(2 * constants.trucks):
        state.travel[wheel] = constants.radius[wheel] * state.turned[wheel]
        state.rolled[0, wheel] += abs(state.travel[wheel])
        state.rolled[1, wheel] += abs(state.travel[wheel])


@compiled
def touches(obstacle: Obstacle, constants: Constants, state: State) -> bool:
    """Return whether a wheel touches an obstacle on the floor, or has reached a scheduled one."""
    if obstacle.scheduled:
        if obstacle.lap >= 0:
            return bool(obstacle.lap == state.lap and state.rolled[1, obstacle.wheel] >= obstacle.after)
        return bool(state.rolled[0, obstacle.wheel] >= obstacle.after)
    truck, right = obstacle.wheel // 2, obstacle.wheel % 2
    arm = constants.wheelbase[truck] * (0.5 - right)
    x, y = transform_xy(state.pose[truck], 0.0, arm)
    return math.hypot(x - obstacle.x, y - obstacle.y) <= obstacle.size


@compiled
def lose_travel(obstacle: Obstacle, constants: Constants, state: State) -> None:
    """Subtract the travel that a wheel loses at one obstacle in this step, uniformly over the crossing.

    The effect `bump` has the exact loss as a function of the travel.
    """
    touching = touches(obstacle, constants, state)
    if touching and not obstacle.encountered:
        obstacle.encountered = 1
        obstacle.remaining = obstacle.span
    elif obstacle.encountered and not touching and not obstacle.scheduled:
        obstacle.encountered = 0
    if obstacle.remaining <= 0.0:
        return
    rolled = constants.radius[obstacle.wheel] * state.turned[obstacle.wheel]
    part = min(abs(rolled), obstacle.remaining)
    obstacle.remaining -= part
    state.travel[obstacle.wheel] -= math.copysign(obstacle.lost * part / obstacle.span, rolled)


@compiled
def disturb(constants: Constants, state: State, obstacles: Record) -> None:
    """Change the travel by the roughness and the bumps of the floor."""
    for truck in range(constants.trucks):
        left, right = 2 * truck, 2 * truck + 1
        if state.turned[left] != 0.0 or state.turned[right] != 0.0:
            first, second = normal_pair(constants.seed, truck * STREAMS + FLOOR, state.steps)
            state.travel[left] += constants.roughness * math.sqrt(abs(state.travel[left])) * first
            state.travel[right] += constants.roughness * math.sqrt(abs(state.travel[right])) * second
    for number in range(len(obstacles)):
        lose_travel(obstacles[number], constants, state)


@compiled
def move(constants: Constants, state: State) -> None:
    """Move each truck along the exact arc of its wheels' travel."""
    for truck in range(constants.trucks):
        left, right = state.travel[2 * truck], state.travel[2 * truck + 1]
        roll_pose(state.pose[truck], left, right, constants.wheelbase[truck])


@compiled
def glide(constants: Constants, state: State, twist: Array) -> None:
    """Move each truck along an arc, by its twist `(T, 3)`: forward [m], left [m] and yaw [rad]."""
    for truck in range(constants.trucks):
        glide_pose(state.pose[truck], twist[truck, 0], twist[truck, 1], twist[truck, 2])


@compiled
def couple(constants: Constants, state: State) -> None:
    """Set angles and length of the linkage from the poses of the trucks, C (9)-(11)."""
    if constants.trucks == 1:
        return
    along = link_heading(state.pose[0], state.pose[1])
    for truck in range(2):
        state.joint[truck] += wrap_angle(state.pose[truck, 2] - along - state.joint[truck])
    state.length = math.hypot(state.pose[0, 0] - state.pose[1, 0], state.pose[0, 1] - state.pose[1, 1])
    if not constants.shortest <= state.length <= constants.longest:
        state.end_stop = 1


@compiled
def read_linkage(constants: Constants, state: State) -> None:
    """Set the counts of the joints and the link, rounded to the nearest count."""
    if constants.trucks == 1:
        return
    for joint in range(2):
        angle = state.joint[joint] + constants.joint_bias[joint]
        state.counts[4 + joint] = math.floor(
            constants.offset[4 + joint] + constants.scale[4 + joint] * angle + 0.5
        )
    length = state.length - constants.link_zero
    state.counts[6] = math.floor(constants.offset[6] + constants.scale[6] * length + 0.5)


@compiled
def turn_wheels(constants: Constants, state: State, command: Array, period: float) -> None:
    """Do the first part of a step: turn the wheels, set their counts and their travel."""
    drive(constants, state, command, period)
    read_wheels(constants, state)
    roll(constants, state)


@compiled
def settle(constants: Constants, state: State) -> None:
    """Do the last part of a step: set the linkage from the trucks, and its counts."""
    couple(constants, state)
    read_linkage(constants, state)
    state.steps += 1


@compiled
def advance(constants_: Record, states: Record, obstacles: Record, command: Array, period: float) -> None:
    """Advance the robot by one period [s] with the commanded wheel speeds [rad/s]."""
    constants, state = constants_[0], states[0]
    turn_wheels(constants, state, command, period)
    disturb(constants, state, obstacles)
    move(constants, state)
    settle(constants, state)


@compiled
def begin_lap(states: Record, lap: int) -> None:
    """Set the number of the current lap, -1 between laps, and the distance rolled in it to 0."""
    states[0].lap = lap
    for wheel in range(4):
        states[0].rolled[1, wheel] = 0.0
