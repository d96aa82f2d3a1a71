"""A program: what to drive, as a table of rows that compiled code works through, with its laps.

Places and headings of a row are given in a frame: the world, in which odometry was initialised, or the
pose at which a lap began. A row that stands still at its end is finished only when all wheels do.
"""

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from motion.errors import ProgramError
from vehicle.compiled import Record, layout
from vehicle.recording import Direction

Follower = Literal["car", "parallel"]

REST, LINE, ARC, TURN, PASS, GOTO = range(6)
KEEP, HERE, WORLD = range(3)


class Row(NamedTuple):
    """One step of a program.

    Attributes:
        kind: REST, LINE, ARC, TURN, PASS or GOTO.
        x: of the line's end, the arc's centre, the via-point or the goal [m].
        y: likewise [m].
        heading: course of a line; heading at the end of a turn (unwrapped) or at the goal [rad].
        reverse: 1 where a line is driven backwards.
        curvature: of an arc, positive to the left; the sharpest allowed on a line or to a via-point [1/m].
        length: of an arc [m].
        tolerance: distance from a via-point at which the next row begins [m].
        speed: of the truck's centre, or of the wheels in a turn on the spot [m/s].
        corner_speed: to which a via-point slows the truck down [m/s].
        duration: of a rest, counted from standstill [s].
        fix: 1 where an absolute fix is due in the middle of a rest.
        truck: 0 to move truck a, 1 to move truck b alone (GOTO).
        frame: KEEP the one before, begin a new one HERE, or go back to the WORLD.
        lap: to which lap the row belongs; -1 between laps.
    """

    kind: int
    x: float = 0.0
    y: float = 0.0
    heading: float = 0.0
    reverse: int = 0
    curvature: float = 1.0
    length: float = 0.0
    tolerance: float = 0.0
    speed: float = 0.0
    corner_speed: float = 0.0
    duration: float = 0.0
    fix: int = 0
    truck: int = 0
    frame: int = KEEP
    lap: int = -1


@dataclass(frozen=True, slots=True)
class Program:
    """What to drive.

    Attributes:
        protocol: its word in `run.toml`: umbmark, extended-umbmark, straight, free.
        rows: in order.
        directions: of each lap.
        side: of the square [m], where there is one.
        follower: how truck b goes with truck a.

    Raises:
        ProgramError: a row that could not be finished.
    """

    protocol: str
    rows: tuple[Row, ...]
    directions: tuple[Direction, ...]
    side: float | None = None
    follower: Follower = "car"

    def __post_init__(self) -> None:
        for number, row in enumerate(self.rows):
            _check(number, row)

    @property
    def table(self) -> Record:
        """The rows as one record array `(R,)`."""
        return np.array([tuple(row) for row in self.rows], layout(Row))


def _check(number: int, row: Row) -> None:
    """Refuse a row that could not be finished."""
    if not all(map(math.isfinite, row)):
        raise ProgramError(number, f"{row} holds a number that is not finite")
    if row.kind != REST and row.speed <= 0.0:
        raise ProgramError(number, f"a speed of {row.speed} m/s; expected more than 0")
    if row.kind == PASS and min(row.tolerance, row.corner_speed, row.curvature) <= 0.0:
        raise ProgramError(
            number, "tolerance, corner speed and curvature of a via-point; expected more than 0"
        )
    if row.kind == ARC and row.curvature == 0.0:
        raise ProgramError(number, "an arc without curvature; use a line")


def rest(duration: float, *, fix: bool = False) -> Row:
    """Stand still for a time [s], with an absolute fix in the middle if asked."""
    return Row(REST, duration=duration, fix=int(fix))


def in_lap(lap: int, rows: list[Row], frame: int = KEEP) -> list[Row]:
    """Return rows as those of one lap; the first of them sets the frame."""
    return [row._replace(lap=lap, frame=KEEP if number else frame) for number, row in enumerate(rows)]
