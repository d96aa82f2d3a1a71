"""The path of a signal through the robot, stage by stage, for one step of time.

drive -> encoder -> ground travel -> body -> linkage -> bus: each stage is one function that takes what
the stage before left in the state. Wheels stand in the order of `WHEELS`, counts in that of `CHANNELS`.
"""

import math
from typing import Annotated

from motion.compiled import Array, IntArray, Record, compiled
from vcan_sim.noise import FLOOR, STREAMS, normal_pair
from vehicle.odometry import advance as advance_pose


class Constants:
    """What does not change while the robot drives.

    Attributes:
        trucks: 1 or 2.
        seed: of the floor.
        wheelbase: true, of each truck [m].
        radius: true, of each wheel [m].
        servo: largest acceleration of each wheel [rad/s^2].
        roughness: of the floor [m/sqrt(m)].
        scale: counts per radian, per metre for the link, with the encoder's sign, of each channel.
        offset: counts at angle 0, or at the nominal link length, of each channel.
        joint_bias: [rad].
        link_zero: length at which the link reads its offset [m].
        shortest: length at the slider's end stop [m].
        longest: likewise [m].
    """

    trucks: int
    seed: int
    wheelbase: Annotated[Array, 2]
    radius: Annotated[Array, 4]
    servo: Annotated[Array, 4]
    roughness: float
    scale: Annotated[Array, 7]
    offset: Annotated[Array, 7]
    joint_bias: Annotated[Array, 2]
    link_zero: float
    shortest: float
    longest: float


class State:
    """What changes with every step.

    Attributes:
        steps: since the start.
        speed: of each wheel [rad/s].
        turned: by each wheel in this step [rad].
        angle: of each wheel since the start [rad].
        travel: over the ground by each wheel in this step [m].
        rolled: by each wheel since the start, and since the lap began, whatever the direction [m].
        lap: that is being driven; -1 between laps.
        pose: true, of each truck.
        joint: true angles, unwrapped [rad].
        length: true, of the link [m].
        end_stop: 1 once the slider was at its end stop.
        counts: of each channel, unwrapped.
    """

    steps: int
    speed: Annotated[Array, 4]
    turned: Annotated[Array, 4]
    angle: Annotated[Array, 4]
    travel: Annotated[Array, 4]
    rolled: Annotated[Array, (2, 4)]
    lap: int
    pose: Annotated[Array, (2, 3)]
    joint: Annotated[Array, 2]
    length: float
    end_stop: int
    counts: Annotated[IntArray, 7]


class Obstacle:
    """A bump as seen by one wheel.

    Attributes:
        wheel: number of the wheel.
        scheduled: 1 where it is put under the wheel, 0 where it lies on the floor.
        lap: in which it is put there; -1 for the whole drive.
        after: rolled way at which it is met [m].
        x: where it lies [m].
        y: likewise [m].
        size: radius of the place [m].
        lost: travel in one crossing [m].
        span: rolled way of one crossing [m].
        remaining: rolled way to the end of the crossing that goes on [m].
        met: 1 from when it is met until the wheel is off it; for good where it was put there.
    """

    wheel: int
    scheduled: int
    lap: int
    after: float
    x: float
    y: float
    size: float
    lost: float
    span: float
    remaining: float
    met: int


advance_arc = compiled(advance_pose)


@compiled
def drive(constants: Constants, state: State, command: Array, period: float) -> None:
    """Turn the wheels: ideal servos follow the commanded speeds [rad/s] within their acceleration."""
    for wheel in range(2 * constants.trucks):
        most = constants.servo[wheel] * period
        state.speed[wheel] += min(max(command[wheel] - state.speed[wheel], -most), most)
        state.turned[wheel] = state.speed[wheel] * period
        state.angle[wheel] += state.turned[wheel]


@compiled
def read_wheels(constants: Constants, state: State) -> None:
    """Quantise the wheels' angles: an incremental encoder counts the lines that have passed."""
    for wheel in range(2 * constants.trucks):
        state.counts[wheel] = math.floor(
            constants.offset[wheel] + constants.scale[wheel] * state.angle[wheel]
        )


@compiled
def touches(obstacle: Obstacle, constants: Constants, state: State) -> bool:
    """Return whether a wheel stands where an obstacle begins."""
    if obstacle.scheduled:
        if obstacle.lap >= 0:
            return bool(obstacle.lap == state.lap and state.rolled[1, obstacle.wheel] >= obstacle.after)
        return bool(state.rolled[0, obstacle.wheel] >= obstacle.after)
    truck, right = obstacle.wheel // 2, obstacle.wheel % 2
    arm = constants.wheelbase[truck] * (0.5 - right)
    heading = state.pose[truck, 2]
    x = state.pose[truck, 0] - arm * math.sin(heading)
    y = state.pose[truck, 1] + arm * math.cos(heading)
    return math.hypot(x - obstacle.x, y - obstacle.y) <= obstacle.size


@compiled
def lose_travel(obstacle: Obstacle, constants: Constants, state: State) -> None:
    """Take what one obstacle costs in this step off its wheel's travel, spread over the crossing."""
    touching = touches(obstacle, constants, state)
    if touching and not obstacle.met:
        obstacle.met = 1
        obstacle.remaining = obstacle.span
    elif obstacle.met and not touching and not obstacle.scheduled:
        obstacle.met = 0
    if obstacle.remaining <= 0.0:
        return
    rolled = constants.radius[obstacle.wheel] * state.turned[obstacle.wheel]
    part = min(abs(rolled), obstacle.remaining)
    obstacle.remaining -= part
    state.travel[obstacle.wheel] -= math.copysign(obstacle.lost * part / obstacle.span, rolled)


@compiled
def roll(constants: Constants, state: State, obstacles: Record) -> None:
    """Turn the wheels' rotation into travel over the ground: true radius, roughness, bumps."""
    for wheel in range(2 * constants.trucks):
        state.travel[wheel] = constants.radius[wheel] * state.turned[wheel]
        state.rolled[0, wheel] += abs(state.travel[wheel])
        state.rolled[1, wheel] += abs(state.travel[wheel])
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
        pose = state.pose[truck, 0], state.pose[truck, 1], state.pose[truck, 2]
        left, right = state.travel[2 * truck], state.travel[2 * truck + 1]
        x, y, heading = advance_arc(pose, left, right, constants.wheelbase[truck])
        state.pose[truck, 0], state.pose[truck, 1], state.pose[truck, 2] = x, y, heading


@compiled
def couple(constants: Constants, state: State) -> None:
    """Let the linkage take up what lies between the trucks: angles and length, C (9)-(11)."""
    if constants.trucks == 1:
        return
    east, north = state.pose[0, 0] - state.pose[1, 0], state.pose[0, 1] - state.pose[1, 1]
    along = math.atan2(north, east)
    for truck in range(2):
        change = state.pose[truck, 2] - along - state.joint[truck]
        state.joint[truck] += (change + math.pi) % (2.0 * math.pi) - math.pi
    state.length = math.hypot(east, north)
    if not constants.shortest <= state.length <= constants.longest:
        state.end_stop = 1


@compiled
def read_linkage(constants: Constants, state: State) -> None:
    """Quantise the joints' angles and the link's length to the nearest count."""
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
def advance(constants_: Record, states: Record, obstacles: Record, command: Array, period: float) -> None:
    """Advance the robot by one period [s] with the commanded wheel speeds [rad/s]."""
    constants, state = constants_[0], states[0]
    drive(constants, state, command, period)
    read_wheels(constants, state)
    roll(constants, state, obstacles)
    move(constants, state)
    couple(constants, state)
    read_linkage(constants, state)
    state.steps += 1


@compiled
def begin_lap(states: Record, lap: int) -> None:
    """Note which lap begins; -1 when one has ended."""
    states[0].lap = lap
    states[0].rolled[1, :] = 0.0
