"""The records that the plant's compiled functions share: constants, state and obstacles.

Wheels stand in the order of `WHEELS`, counts in that of `CHANNELS`; truck a is 0, truck b 1.
"""

from typing import Annotated

from omnimate.vehicle.compiled import Array, IntArray


class Constants:
    """Constants of a true robot on its floor.

    Attributes:
        trucks: Number of trucks, 1 or 2.
        seed: Seed of the floor.
        wheelbase: True wheelbase of each truck [m].
        radius: True radius of each wheel [m].
        servo: Largest acceleration of each wheel [rad/s^2].
        roughness: Roughness of the floor [m/sqrt(m)].
        scale: Counts per radian, and for the link per metre, of each channel, with the encoder's sign.
        offset: Counts of each channel at angle 0, and for the link at its nominal length.
        joint_bias: Reading of each joint minus its true angle [rad].
        link_zero: Length of the link at which its count is the offset [m].
        shortest: Length of the link at the slider's inner end stop [m].
        longest: Length of the link at the slider's outer end stop [m].
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
    """State of a robot, changed by each step.

    Attributes:
        steps: Number of steps since the start.
        speed: Speed of each wheel [rad/s].
        turned: Angle by which each wheel turned in this step [rad].
        angle: Angle of each wheel since the start [rad].
        travel: Travel of each wheel over the ground in this step [m].
        rolled: Distance rolled by each wheel, in either direction, since the start and since the lap began
            [m].
        lap: Number of the lap that is being driven; -1 between laps.
        pose: True pose of each truck [m, m, rad].
        joint: True angles of the joints, unwrapped [rad].
        length: True length of the link [m].
        end_stop: 1 after the slider was at its end stop.
        counts: Counts of each channel, unwrapped.
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
    """A bump and one wheel that may cross it.

    Attributes:
        wheel: Number of the wheel.
        scheduled: 1 for an obstacle put under the wheel, 0 for one that lies on the floor.
        lap: Number of the lap in which the obstacle is put there; -1 for the whole drive.
        after: Rolled distance at which the wheel encounters the obstacle [m].
        x: Place of the obstacle on the floor, x [m].
        y: Place of the obstacle on the floor, y [m].
        size: Radius of the place within which the wheel encounters the obstacle [m].
        lost: Distance that is rolled but not travelled in one crossing [m].
        span: Distance that is rolled in one crossing [m].
        remaining: Distance to roll until the end of the present crossing [m].
        encountered: 1 while the wheel is on the obstacle; for a scheduled one, 1 from the first contact on.
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
    encountered: int
