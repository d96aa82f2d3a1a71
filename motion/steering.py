"""Steering of one truck: along a line or an arc, on the spot, towards a point.

Each function returns the speed of the truck's centre [m/s], its turn rate [rad/s], and whether the end
is reached. Steering acts per metre of travel, so that a slow truck turns slowly.
"""

import math

from omnimate.motion.records import Settings
from omnimate.vehicle.compiled import compiled
from omnimate.vehicle.se2 import rotate_xy, wrap_angle

Steer = tuple[float, float, bool]

LOOKAHEAD = 1.0  # [m] a truck off its line aims at the point this far ahead
STIFFNESS = 4.0  # [1/m] curvature per radian off course; with the above critically damped
BRAKING_SHARE = 0.8  # [1] share of the acceleration limit for braking; the rest is for steering
SETTLING_SHARE = 0.25  # [1] of the remaining distance per step at the end: no overshoot with a step's delay


@compiled
def clip(value: float, bound: float) -> float:
    """Return the value between -bound and bound."""
    return min(max(value, -bound), bound)


@compiled
def approach_speed(remaining: float, tolerance: float, speed: float, settings: Settings) -> float:
    """Return the speed [m/s], with its sign, that stops at the end of a remaining distance [m].

    Constant deceleration; in the last millimetre a constant share of the remaining distance per step.
    """
    braking = BRAKING_SHARE * settings.acceleration
    distance = abs(remaining)
    if distance <= tolerance:
        return 0.0
    gain = min(SETTLING_SHARE / settings.period, 0.5 * math.sqrt(braking / tolerance))
    last = braking / (gain * gain)
    fast = gain * distance if distance <= last else math.sqrt(2.0 * braking * distance - braking * last)
    return math.copysign(min(fast, speed), remaining)


@compiled
def path_turn_rate(
    speed: float, aside: float, course: float, travel_heading: float, curvature: float, sharpest: float
) -> float:
    """Return the turn rate [rad/s] of a truck that follows a path of a curvature and a course.

    `aside` is its distance to the left of the path [m], `travel_heading` that in which it moves, of its back
    where it reverses, `sharpest` the largest curvature that may be added [1/m]. Nothing is steered while it
    drives back from an overshoot: a negative speed along the path.
    """
    off = wrap_angle(course - math.atan(aside / LOOKAHEAD) - travel_heading)
    return max(speed, 0.0) * (curvature + clip(STIFFNESS * off, sharpest))


@compiled
def steer_line(
    x: float,
    y: float,
    heading: float,
    end_x: float,
    end_y: float,
    course: float,
    reverse: int,
    sharpest: float,
    speed: float,
    tolerance: float,
    settings: Settings,
) -> Steer:
    """Drive along the line that ends at a point with a course [rad], front or back first, and stop there."""
    remaining, aside = rotate_xy(-course, end_x - x, end_y - y)
    ahead = approach_speed(remaining, tolerance, speed, settings)
    travel_heading = heading + math.pi * reverse
    turn = path_turn_rate(ahead, -aside, course, travel_heading, 0.0, sharpest)
    return (-ahead if reverse else ahead), turn, ahead == 0.0


@compiled
def steer_arc(
    x: float,
    y: float,
    heading: float,
    centre_x: float,
    centre_y: float,
    curvature: float,
    remaining: float,
    speed: float,
    tolerance: float,
    settings: Settings,
) -> Steer:
    """Drive along a circle around a point over a remaining distance [m], and stop there."""
    side = math.copysign(1.0, curvature)
    aside = side * (1.0 / abs(curvature) - math.hypot(x - centre_x, y - centre_y))
    course = math.atan2(y - centre_y, x - centre_x) + side * math.pi / 2.0
    ahead = approach_speed(remaining, tolerance, speed, settings)
    return ahead, path_turn_rate(ahead, aside, course, heading, curvature, abs(curvature)), ahead == 0.0


@compiled
def steer_turn(remaining: float, speed: float, truck: int, settings: Settings) -> Steer:
    """Turn on the spot by a remaining angle [rad], the wheels at a speed [m/s]."""
    arm = 0.5 * settings.wheelbase[truck]
    rim = approach_speed(remaining * arm, settings.turn_tolerance[truck] * arm, speed, settings)
    return 0.0, rim / arm, rim == 0.0


@compiled
def steer_past(
    x: float,
    y: float,
    heading: float,
    via_x: float,
    via_y: float,
    near: float,
    sharpest: float,
    speed: float,
    corner_speed: float,
    settings: Settings,
) -> Steer:
    """Aim at a via-point and slow down before it, until it is near enough [m] to go on, O 3.2."""
    distance = math.hypot(via_x - x, via_y - y)
    off = wrap_angle(math.atan2(via_y - y, via_x - x) - heading)
    braking = 2.0 * BRAKING_SHARE * settings.acceleration * max(distance - near, 0.0)
    ahead = min(speed, math.sqrt(corner_speed * corner_speed + braking))
    if abs(off) > math.pi / 4.0:
        ahead = min(ahead, corner_speed)
    return ahead, ahead * clip(STIFFNESS * off, sharpest), distance <= near
