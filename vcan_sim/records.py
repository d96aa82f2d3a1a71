"""The records that the plant's compiled functions share: constants, state and obstacles.

Wheels stand in the order of `WHEELS`, counts in that of `CHANNELS`; truck a is 0, truck b 1.
"""

from typing import Annotated

from omnimate.vehicle.compiled import Array, IntArray


class Constants:
    """Constants of a true robot on its floor."""

    trucks: int  # number of trucks, 1 or 2
    seed: int  # seed of the floor
    wheelbase: Annotated[Array, 2]  # true wheelbase of each truck [m]
    radius: Annotated[Array, 4]  # true radius of each wheel [m]
    servo: Annotated[Array, 4]  # largest acceleration of each wheel [rad/s^2]
    roughness: float  # roughness of the floor [m/sqrt(m)]
    # counts per radian, and for the link per metre, of each channel, with the encoder's sign
    scale: Annotated[Array, 7]
    offset: Annotated[Array, 7]  # counts of each channel at angle 0, and for the link at its nominal length
    joint_bias: Annotated[Array, 2]  # reading of each joint minus its true angle [rad]
    link_zero: float  # length of the link at which its count is the offset [m]
    shortest: float  # length of the link at the slider's inner end stop [m]
    longest: float  # length of the link at the slider's outer end stop [m]


class State:
    """State of a robot, changed by each step."""

    steps: int  # number of steps since the start
    speed: Annotated[Array, 4]  # speed of each wheel [rad/s]
    turned: Annotated[Array, 4]  # angle by which each wheel turned in this step [rad]
    angle: Annotated[Array, 4]  # angle of each wheel since the start [rad]
    travel: Annotated[Array, 4]  # travel of each wheel over the ground in this step [m]
    # distance rolled by each wheel, in either direction, since the start and since the lap began [m]
    rolled: Annotated[Array, (2, 4)]
    lap: int  # number of the lap that is being driven; -1 between laps
    pose: Annotated[Array, (2, 3)]  # true pose of each truck [m, m, rad]
    joint: Annotated[Array, 2]  # true angles of the joints, unwrapped [rad]
    length: float  # true length of the link [m]
    end_stop: int  # 1 after the slider was at its end stop
    counts: Annotated[IntArray, 7]  # counts of each channel, unwrapped


class Obstacle:
    """A bump and one wheel that may cross it."""

    wheel: int  # number of the wheel
    scheduled: int  # 1 for an obstacle put under the wheel, 0 for one that lies on the floor
    lap: int  # number of the lap in which the obstacle is put there; -1 for the whole drive
    after: float  # rolled distance at which the wheel encounters the obstacle [m]
    x: float  # place of the obstacle on the floor, x [m]
    y: float  # place of the obstacle on the floor, y [m]
    size: float  # radius of the place within which the wheel encounters the obstacle [m]
    lost: float  # distance that is rolled but not travelled in one crossing [m]
    span: float  # distance that is rolled in one crossing [m]
    remaining: float  # distance to roll until the end of the present crossing [m]
    encountered: int  # 1 while the wheel is on the obstacle; for a scheduled one, 1 from the first contact on
