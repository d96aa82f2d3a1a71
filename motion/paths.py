"""The drives of the three papers, and free ones, as programs.

Every lap begins and ends at rest; before and after it is a rest of about 2 s with an absolute fix,
from which the operator initialises the odometry again, U III-C 1) and O 3.2.
"""

import math
from collections.abc import Sequence
from typing import Literal

import numpy as np

from omnimate.motion.program import (
    ARC,
    GOTO,
    HERE,
    LINE,
    PASS,
    TURN,
    WORLD,
    Program,
    Row,
    in_lap,
    rest,
)
from omnimate.vehicle.recording import Direction

Point = tuple[float, float]

PAUSE = 0.3  # [s] stop at a corner (assumption)
STOP = 2.0  # [s] rest between laps, for a fix (assumption)


def _sign(direction: Direction) -> int:
    return -1 if direction == "cw" else 1


def _no_direction(laps: int) -> tuple[Direction, ...]:
    none: Direction = "none"
    return (none,) * laps


def _from_home(
    laps: list[list[Row]], link_length: float | None, speed: float, *, home_first: bool = False
) -> tuple[Row, ...]:
    """Return laps in formation between rests, the later ones after a drive home, truck b after truck a."""
    home = [rest(STOP, fix=True), Row(GOTO, speed=speed, frame=WORLD)]
    if link_length is not None:
        home.append(Row(GOTO, x=-link_length, speed=speed, truck=1, frame=WORLD))
    rows: list[Row] = []
    for lap, drive in enumerate(laps):
        rows += home if lap or home_first else []
        rows += [rest(STOP, fix=True), *in_lap(lap, drive, HERE)]
    return (*rows, rest(STOP, fix=True))


def _square(side: float, direction: Direction, speed: float) -> list[Row]:
    """One UMBmark lap, U III-C: four legs with stops, four turns on the spot including the last."""
    rows: list[Row] = []
    x, y, heading = 0.0, 0.0, 0.0
    for _ in range(4):
        x, y = x + side * math.cos(heading), y + side * math.sin(heading)
        rows += [Row(LINE, x=x, y=y, heading=heading, speed=speed), rest(PAUSE)]
        heading += _sign(direction) * math.pi / 2.0
        rows += [Row(TURN, heading=heading, speed=speed), rest(PAUSE)]
    return rows


def umbmark(
    side: float = 4.0,
    runs: int = 5,
    *,
    order: Literal["alternating", "grouped"] = "alternating",
    speed: float = 0.2,
    link_length: float | None = None,
) -> Program:
    """Return the UMBmark: `runs` squares in each direction, each begun within centimetres of home, U III-C.

    Args:
        side: Side of the square [m].
        runs: Number of runs in each direction; cw comes first.
        order: Whether cw and ccw alternate, or all cw runs come before all ccw runs.
        speed: Speed of the wheels [m/s]; U uses 0.2.
        link_length: Length of the link of a robot with two trucks [m]: b keeps a's heading and formation, so
            that the square calibrates both; None for a single truck.
    """
    pairs: list[Direction] = ["cw", "ccw"]
    directions = pairs * runs if order == "alternating" else [pairs[0]] * runs + [pairs[1]] * runs
    return squares(directions, side, speed=speed, link_length=link_length)


def squares(
    directions: list[Direction],
    side: float = 4.0,
    *,
    speed: float = 0.2,
    link_length: float | None = None,
    home_first: bool = False,
) -> Program:
    """Return UMBmark squares in the directions given; the arguments are those of `umbmark`.

    With `home_first` the robot drives home before the first square, too, as it does before every other.
    """
    laps = [_square(side, direction, speed) for direction in directions]
    rows = _from_home(laps, link_length, speed, home_first=home_first)
    return Program("umbmark", rows, tuple(directions), side, "parallel")


def out_and_back(
    length: float = 18.0, runs: int = 3, *, speed: float = 0.5, link_length: float | None = None
) -> Program:
    """Return straight drives out, and back in reverse, C 6.1; one lap of direction none for each.

    Args:
        length: [m].
        runs: Number of drives.
        speed: [m/s].
        link_length: Length of the link of a robot with two trucks [m]; None for a single truck.
    """
    outward = Row(LINE, x=length, speed=speed)
    back = Row(LINE, heading=math.pi, reverse=1, speed=speed)
    laps = [[outward, rest(PAUSE), back, rest(PAUSE)]] * runs
    rows = _from_home(laps, link_length, speed)
    return Program("straight", rows, _no_direction(runs), None, "parallel")


def via_points(
    points: list[Point], tolerance: float, speed: float, corner_speed: float | None = None
) -> list[Row]:
    """Return rows that pass by points within a tolerance without stopping, O 3.2 (`pass_by`).

    Args:
        points: [m] in the order in which they are passed.
        tolerance: Distance at which the truck turns to the next point [m].
        speed: [m/s].
        corner_speed: Speed near a point [m/s]; None halves the speed.
    """
    slow = 0.5 * speed if corner_speed is None else corner_speed
    sharpest = 1.0 / max(tolerance, 0.05)
    return [
        Row(PASS, x=x, y=y, tolerance=tolerance, speed=speed, corner_speed=slow, curvature=sharpest)
        for x, y in points
    ]


def _loop(points: list[Point], tolerance: float, speed: float) -> list[Row]:
    """Pass by all points, then come home along the x-axis and stop."""
    home = Row(LINE, speed=speed, curvature=1.0 / max(tolerance, 0.05))
    return [*via_points(points, tolerance, speed), home, rest(PAUSE)]


def _loops(loops: list[list[Row]], directions: Sequence[Direction], protocol: str) -> Program:
    rows: list[Row] = []
    for lap, loop in enumerate(loops):
        rows += [rest(STOP, fix=True), *in_lap(lap, loop, WORLD)]
    rows.append(rest(STOP, fix=True))
    return Program(protocol, tuple(rows), tuple(directions), None, "car")


def rounded_rectangle(
    length: float,
    width: float,
    directions: list[Direction],
    *,
    tolerance: float = 0.5,
    speed: float = 0.3,
    first: float | None = None,
) -> Program:
    """Return laps of a rectangle whose corners are passed by, begun and ended on one of its sides.

    Args:
        length: Length of the side along which the robot starts [m]; 7 x 4 m with 0.2 m of tolerance is C 6.2,
            6 x 3.25 m with 0.5 m is the 18.5 m of O 3.
        width: Length of the other side [m].
        directions: Direction of each lap.
        tolerance: Distance from a corner at which the robot turns to the next [m].
        speed: [m/s]; O drives at 0.3 at most, C slightly below 0.5.
        first: Distance from the start to the first corner [m]; None starts in the middle of the side.
    """
    ahead = 0.5 * length if first is None else first
    behind = ahead - length
    loops = []
    for direction in directions:
        y = _sign(direction) * width
        loops.append(_loop([(ahead, 0.0), (ahead, y), (behind, y), (behind, 0.0)], tolerance, speed))
    return _loops(loops, directions, "extended-umbmark")


def free(
    seed: int = 0,
    laps: int = 3,
    *,
    points: int = 8,
    area: Point = (6.0, 4.0),
    tolerance: float = 0.5,
    speed: float = 0.4,
) -> Program:
    """Return smooth drives past random points, each ending at home along the x-axis.

    Args:
        seed: Seed of the random points.
        laps: Number of drives.
        points: Number of points that each drive passes.
        area: Length and width of the area around the start [m].
        tolerance: Distance from a point at which the robot turns to the next [m].
        speed: [m/s].
    """
    chance = np.random.default_rng(seed)
    loops = []
    for _ in range(laps):
        steps = chance.uniform(-0.5, 0.5, (points, 2)) * np.array(area)
        points_passed = [(float(x), float(y)) for x, y in steps]
        loops.append(_loop([*points_passed, (-0.75 * area[0], 0.0)], tolerance, speed))
    return _loops(loops, _no_direction(laps), "free")


def figure_eight(radius: float = 1.0, laps: int = 3, *, speed: float = 0.3) -> Program:
    """Return figures of eight: a circle to the left, then one to the right, of a radius [m]."""
    circles = [
        Row(ARC, y=turn * radius, curvature=turn / radius, length=2.0 * math.pi * radius, speed=speed)
        for turn in (1, -1)
    ]
    return _loops([[*circles, rest(PAUSE)]] * laps, _no_direction(laps), "free")
