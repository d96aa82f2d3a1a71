"""Wheel speeds of a truck within its limits, and control of truck b relative to truck a.

Truck b follows as a car's rear axle, or in formation: from truck a's speed and the readings of the linkage,
to b's speed [m/s] and turn rate [rad/s]. The slider takes up the remainder.
"""

import math

from omnimate.motion.records import Settings, State
from omnimate.vehicle.compiled import compiled
from omnimate.vehicle.se2 import rotate_xy, wrap_angle

LENGTH_GAIN = 1.0  # [1/s] speed of b per error of the link's length
JOINT_GAIN = 2.0  # [1/s] turn rate of b per angle of joint_b
HEADING_GAIN = 1.0  # [1/s] turn rate of b per difference of headings
OFFSET_GAIN = 4.0  # [1/m^2] curvature per sideways offset in the formation
MIN_JOINT_COSINE = 0.2  # [1] lower limit of cos(joint_b) in the speed of b


@compiled
def follow_like_car(speed: float, state: State, settings: Settings) -> tuple[float, float]:
    """Face the centre of truck a loosely and keep the link's length, O 3.2."""
    along = speed * math.cos(state.link[0]) + LENGTH_GAIN * (state.link[2] - settings.link_length)
    behind = wrap_angle(state.link[1])
    return along / max(math.cos(behind), MIN_JOINT_COSINE), -JOINT_GAIN * behind


@compiled
def keep_formation(speed: float, turn: float, state: State, settings: Settings) -> tuple[float, float]:
    """Keep the heading of truck a and the place that the link had in the world: the deck translates."""
    cos, sin = math.cos(state.formation), math.sin(state.formation)
    east = state.pose[0, 0] - settings.link_length * cos - state.pose[1, 0]
    north = state.pose[0, 1] - settings.link_length * sin - state.pose[1, 1]
    ahead, aside = rotate_xy(-state.pose[1, 2], east, north)
    off = wrap_angle(state.link[0] - state.link[1])
    rate = turn + HEADING_GAIN * off + OFFSET_GAIN * speed * aside
    return speed * math.cos(off) + LENGTH_GAIN * ahead, rate


@compiled
def stopped(truck: int, state: State) -> bool:
    """Return whether both wheels of a truck were commanded to stand in the step before."""
    return bool(state.speeds[2 * truck] == 0.0 and state.speeds[2 * truck + 1] == 0.0)


@compiled
def drive_truck(truck: int, speed: float, turn: float, state: State, settings: Settings) -> None:
    """Bring both wheels of a truck as near to a speed [m/s] and turn rate [rad/s] as the limits allow.

    Too fast a pair of wheels is slowed down in proportion, so that the path keeps its curvature; too
    large a step is shortened in proportion.
    """
    left, right = 2 * truck, 2 * truck + 1
    rim = 0.5 * settings.wheelbase[truck] * turn
    fastest = max(abs(speed - rim), abs(speed + rim), settings.speed)
    scale = settings.speed / fastest
    step_left = (speed - rim) * scale - state.speeds[left]
    step_right = (speed + rim) * scale - state.speeds[right]
    largest = settings.acceleration * settings.period
    share = largest / max(abs(step_left), abs(step_right), largest)
    if share == 1.0:  # exactly, so that a wheel that is to stand does stand
        state.speeds[left] = (speed - rim) * scale
        state.speeds[right] = (speed + rim) * scale
        return
    state.speeds[left] += share * step_left
    state.speeds[right] += share * step_right
