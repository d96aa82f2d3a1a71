"""How truck b goes with truck a: as a car's rear axle, or in formation.

Both work from truck a's speed and from what the linkage reads, and return b's speed [m/s] and turn rate
[rad/s]. The slider takes up what they leave.
"""

import math

from omnimate.motion.records import Settings, State
from omnimate.vehicle.compiled import compiled
from omnimate.vehicle.se2 import rotate_xy, wrap_angle

LENGTH_GAIN = 1.0  # [1/s] slider error that is driven out per second
FACING_GAIN = 2.0  # [1/s] turn rate per radian that b faces off a, loosely
HEADING_GAIN = 1.0  # [1/s] likewise between the headings of a and b
ASIDE_GAIN = 4.0  # [1/m^2] curvature per metre off the place in the formation
STEEPEST = 0.2  # cosine of joint_b below which b does not speed up any more


@compiled
def follow_like_car(speed: float, state: State, settings: Settings) -> tuple[float, float]:
    """Face the centre of truck a loosely and keep the link's length, O 3.2."""
    along = speed * math.cos(state.link[0]) + LENGTH_GAIN * (state.link[2] - settings.link_length)
    behind = wrap_angle(state.link[1])
    return along / max(math.cos(behind), STEEPEST), -FACING_GAIN * behind


@compiled
def keep_formation(speed: float, turn: float, state: State, settings: Settings) -> tuple[float, float]:
    """Keep the heading of truck a and the place that the link had in the world: the deck translates."""
    cos, sin = math.cos(state.formation), math.sin(state.formation)
    east = state.pose[0, 0] - settings.link_length * cos - state.pose[1, 0]
    north = state.pose[0, 1] - settings.link_length * sin - state.pose[1, 1]
    ahead, aside = rotate_xy(-state.pose[1, 2], east, north)
    off = wrap_angle(state.link[0] - state.link[1])
    rate = turn + HEADING_GAIN * off + ASIDE_GAIN * speed * aside
    return speed * math.cos(off) + LENGTH_GAIN * ahead, rate
