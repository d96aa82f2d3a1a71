"""One step through a program: from the pose by odometry to the speeds of all wheels within their limits.

Truck b follows as a car's rear axle, or in formation: from truck a's speed and the readings of the linkage,
to b's speed [m/s] and turn rate [rad/s]. The slider takes up the remainder.
"""

import math

from omnimate.motion.program import ARC, GOTO, HERE, LINE, PASS, REST, TURN, WORLD, Row
from omnimate.motion.records import Settings, State
from omnimate.motion.steering import Steer, steer_arc, steer_line, steer_past, steer_turn
from omnimate.vehicle.compiled import Array, Record, compiled
from omnimate.vehicle.linkage import place_follower
from omnimate.vehicle.se2 import rotate_xy, transform_xy, wrap_angle

GOAL_TOLERANCE = 0.005  # [m] distance from a goal within which a truck need not drive (assumption)
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


@compiled
def update_poses(x: float, y: float, theta: float, link: tuple[float, float, float], state: State) -> None:
    """Update the pose of truck a and the linkage reading, and place truck b, C (16)."""
    state.heading += wrap_angle(theta - state.heading)
    state.pose[0, 0], state.pose[0, 1], state.pose[0, 2] = x, y, theta
    state.link[0], state.link[1], state.link[2] = link
    along = theta - link[0]
    place_follower(state.pose[1], state.pose[0], link[2], along)
    state.pose[1, 2] = along + link[1]


@compiled
def begin_row(row: Row, state: State) -> None:
    """Begin a row: set its frame, and store the initial formation."""
    if row.frame == HERE:
        state.frame[0], state.frame[1], state.frame[2] = state.pose[0, 0], state.pose[0, 1], state.heading
    elif row.frame == WORLD:
        state.frame[0], state.frame[1], state.frame[2] = 0.0, 0.0, 0.0
    state.formation = state.pose[0, 2] - state.link[0]
    state.lap = row.lap
    state.phase = 0
    state.rested = 0
    state.progress = 0.0
    centre_x, centre_y = goal_position(row, state)
    state.bearing = math.atan2(state.pose[0, 1] - centre_y, state.pose[0, 0] - centre_x)


@compiled
def goal_position(row: Row, state: State) -> tuple[float, float]:
    """Return the row's goal in the frame of the poses [m]."""
    return transform_xy(state.frame, row.x, row.y)


@compiled
def stand_still(row: Row, state: State, settings: Settings) -> Steer:
    """Stand still for the row's duration; in its middle a fix is due if asked for."""
    steps = max(2, round(row.duration / settings.period))
    if state.at_rest:
        state.rested += 1
        state.fix_due = 1 if row.fix and state.rested == steps // 2 else 0
    return 0.0, 0.0, state.rested >= steps


@compiled
def drive_arc(row: Row, state: State, settings: Settings) -> Steer:
    """Drive along the row's arc, measuring the travel by the angle around its centre."""
    x, y, heading = state.pose[0, 0], state.pose[0, 1], state.pose[0, 2]
    centre_x, centre_y = goal_position(row, state)
    bearing = math.atan2(y - centre_y, x - centre_x)
    state.progress += wrap_angle(bearing - state.bearing) / row.curvature
    state.bearing = bearing
    remaining = row.length - state.progress
    tolerance = settings.tolerance[0]
    return steer_arc(
        x, y, heading, centre_x, centre_y, row.curvature, remaining, row.speed, tolerance, settings
    )


@compiled
def drive_to_goal(row: Row, state: State, settings: Settings) -> Steer:
    """Turn towards a goal, front or back, whichever is nearer; drive there; turn to the heading wanted."""
    truck = row.truck
    x, y, heading = state.pose[truck, 0], state.pose[truck, 1], state.pose[truck, 2]
    goal_x, goal_y = goal_position(row, state)
    if state.phase == 0:
        state.course = math.atan2(goal_y - y, goal_x - x)
        state.backwards = 1 if abs(wrap_angle(state.course - heading)) > math.pi / 2.0 else 0
        close = max(GOAL_TOLERANCE, 2.0 * settings.tolerance[truck])
        state.phase = 3 if math.hypot(goal_x - x, goal_y - y) < close else 1
    if state.phase == 2:
        tolerance = settings.tolerance[truck]
        leg = steer_line(
            x, y, heading, goal_x, goal_y, state.course, state.backwards, 1.0, row.speed, tolerance, settings
        )
        state.phase += 1 if leg[2] and stopped(truck, state) else 0
        return leg[0], leg[1], False
    wanted = state.course + math.pi * state.backwards if state.phase == 1 else state.frame[2] + row.heading
    turn = steer_turn(wrap_angle(wanted - heading), row.speed, truck, settings)
    if state.phase == 1:
        state.phase += 1 if turn[2] and stopped(truck, state) else 0
        return turn[0], turn[1], False
    return turn


@compiled
def steer(row: Row, state: State, settings: Settings) -> Steer:
    """Return speed [m/s] and turn rate [rad/s] of the row's truck, and whether the row is finished."""
    x, y, heading = state.pose[0, 0], state.pose[0, 1], state.pose[0, 2]
    to_x, to_y = goal_position(row, state)
    if row.kind == REST:
        return stand_still(row, state, settings)
    if row.kind == PASS:
        return steer_past(
            x, y, heading, to_x, to_y, row.tolerance, row.curvature, row.speed, row.corner_speed, settings
        )
    speed, turn, reached = 0.0, 0.0, False
    if row.kind == LINE:
        course, tolerance = state.frame[2] + row.heading, settings.tolerance[0]
        speed, turn, reached = steer_line(
            x, y, heading, to_x, to_y, course, row.reverse, row.curvature, row.speed, tolerance, settings
        )
    elif row.kind == TURN:
        remaining = state.frame[2] + row.heading - state.heading
        speed, turn, reached = steer_turn(remaining, row.speed, 0, settings)
    elif row.kind == ARC:
        speed, turn, reached = drive_arc(row, state, settings)
    elif row.kind == GOTO:
        speed, turn, reached = drive_to_goal(row, state, settings)
    return speed, turn, reached and stopped(row.truck, state)


@compiled
def set_wheel_speeds(
    kind: int, truck: int, speed: float, turn: float, state: State, settings: Settings
) -> None:
    """Set the speeds of all wheels, within their limits; the other truck follows truck a, or stands."""
    drive_truck(truck, speed, turn, state, settings)
    if settings.trucks == 1:
        return
    if kind == REST or truck == 1:
        drive_truck(1 - truck, 0.0, 0.0, state, settings)
        return
    speed = 0.5 * (state.speeds[0] + state.speeds[1])
    turn = (state.speeds[1] - state.speeds[0]) / settings.wheelbase[0]
    if settings.parallel:
        speed, turn = keep_formation(speed, turn, state, settings)
    else:
        speed, turn = follow_like_car(speed, state, settings)
    drive_truck(1, speed, turn, state, settings)


@compiled
def step(
    rows: Record,
    all_settings: Record,
    states: Record,
    pose: tuple[float, float, float],
    link: tuple[float, float, float],
    wheels: Array,
) -> bool:
    """Process a pose of truck a and a reading of the linkage; write the wheel speeds [rad/s] to `wheels`.

    Returns:
        Whether a lap began or ended, a fix is due, or the program is done.
    """
    settings, state = all_settings[0], states[0]
    update_poses(pose[0], pose[1], pose[2], link, state)
    state.at_rest = 1 if stopped(0, state) and stopped(1, state) else 0
    state.fix_due = 0
    lap, kind, truck = state.lap, REST, 0
    speed, turn, finished = 0.0, 0.0, True
    if not state.entered:
        state.entered = 1
        state.row = -1
    elif state.row < len(rows):
        speed, turn, finished = steer(rows[state.row], state, settings)
    while finished and state.row < len(rows):
        state.row += 1
        state.lap = -1
        speed, turn, finished = 0.0, 0.0, False
        if state.row < len(rows):
            begin_row(rows[state.row], state)
            speed, turn, finished = steer(rows[state.row], state, settings)
    if state.row < len(rows):
        kind, truck = rows[state.row].kind, rows[state.row].truck
    set_wheel_speeds(kind, truck, speed, turn, state, settings)
    for wheel in range(2 * settings.trucks):
        wheels[wheel] = state.speeds[wheel] / settings.radius[wheel]
    return bool(state.lap != lap or state.fix_due or state.row == len(rows))
