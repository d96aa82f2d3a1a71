"""The records that the plant's compiled functions share: what stays, what changes, and the obstacles.

Wheels stand in the order of `WHEELS`, counts in that of `CHANNELS`; truck a is 0, truck b 1.
"""

from typing import Annotated

from vehicle.compiled import Array, IntArray


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
